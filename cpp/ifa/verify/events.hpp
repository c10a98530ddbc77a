// Audible hits, the events they chain into, and the marks those answer.
#pragma once

#include "ifa/verify/certificate.hpp"
#include "ifa/verify/contacts.hpp"

namespace ifa::verify {

// Fills hits, events, marks, extra_events_s, missed_hits, extra_hits and max_abs_error_s.
//
// Each mark takes the nearest event start within half the gap to its neighbours, at most 50 ms. Two readings
// of the hits are tried, with and without those inside the hysteresis band (of speed, and of 0.1 ms in the
// merge gap): a mark may be met in either, and an event is extra only if it is certain and neither it nor the
// event that contains it in the wider reading starts at a mark.
void match_events(const Impacts& impacts, const MarkSet& marks, const Claims& claims, const Options& options,
                  Certificate* certificate);

}  // namespace ifa::verify
