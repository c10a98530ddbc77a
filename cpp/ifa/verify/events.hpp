// Audible hits, the events they chain into, and the marks those answer.
#pragma once

#include "ifa/verify/certificate.hpp"
#include "ifa/verify/contacts.hpp"

namespace ifa::verify {

// Fills hits, events, marks, extra_events_s, missed_hits, extra_hits and max_abs_error_s.
//
// Each mark takes the nearest event start within half the gap to its neighbours, at most 50 ms.
//
// The audible speed is one of the simulated body, so the claimed retiming is undone before comparing. What
// lies on the edge can be read either way: the audible speed may be anywhere in its hysteresis band, the
// merge gap within 0.1 ms, measured before retiming or after. Each choice is a reading of the hits. A mark
// may be met in any of them; a hit is extra if it starts an event without the help of doubtful hits and in no
// reading belongs to an event that starts at a mark.
void match_events(const Impacts& impacts, const MarkSet& marks, const Claims& claims, const Options& options,
                  Certificate* certificate);

}  // namespace ifa::verify
