// The events that hits or touches chain into, and the marks those answer.
#pragma once

#include "ifa/verify/certificate.hpp"
#include "ifa/verify/contacts.hpp"
#include "ifa/verify/touches.hpp"

namespace ifa::verify {

// Fills hits, events, marks, extra_events_s, missed_hits, extra_hits and max_abs_error_s. `touches` are read
// only where contact makes the events; `retime_at` is the claimed ratio, with each event at its mark.
//
// Each mark takes the nearest event start within half the gap to its neighbours, at most 50 ms.
//
// What lies on the edge can be read either way. The audible speed is one of the simulated body, so the
// claimed retiming is undone before comparing; it may be anywhere in its hysteresis band. Doubtful touches
// may be flight. The merge gap may differ by 0.1 ms, is measured before retiming or after, and where contact
// fades out between two samples, from either. Each choice is a reading. A mark may be met in any of them; a
// hit or touch is extra if it starts an event without the help of doubtful ones and in no reading belongs to
// an event that starts at a mark, or (hits) within the span of one.
void match_events(const Impacts& impacts, const std::vector<Touch>& touches, const MarkSet& marks,
                  const Options& options, const RetimeAt& retime_at, Certificate* certificate);

}  // namespace ifa::verify
