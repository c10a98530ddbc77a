// Audible hits, the events they chain into, and the marks those answer.
#pragma once

#include "ifa/verify/certificate.hpp"
#include "ifa/verify/contacts.hpp"

namespace ifa::verify {

// Fills hits, events, marks, extra_events_s, missed_hits, extra_hits and max_abs_error_s.
//
// Each mark takes the nearest event start within half the gap to its neighbours, at most 50 ms. Inside the
// hysteresis band the audible speed may lie anywhere, and the merge gap anywhere within 0.1 ms: each choice
// gives a reading of the hits. A mark may be met in any of them; a hit is extra only if it certainly starts
// an event and in no reading belongs to an event that starts at a mark.
void match_events(const Impacts& impacts, const MarkSet& marks, const Claims& claims, const Options& options,
                  Certificate* certificate);

}  // namespace ifa::verify
