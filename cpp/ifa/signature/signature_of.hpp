// The contact-time signature of a simulated run: the marks that a motion like it would have met.
#pragma once

#include "ifa/rigid/run.hpp"
#include "ifa/signature/events.hpp"
#include "ifa/signature/marks.hpp"

namespace ifa {

// One mark for each event of the run's audible hits, at times of the run; hits only, slip makes no mark. A
// chain shorter than the merge gap has no duration, and then its centroid is unknown. `rest` where the run
// came to rest, which no hit follows. Throws ArgumentError where no hit is audible. What it returns passes
// `validate` for the same merge gap, which must be above 0, as must the audible speed.
Marks signature_of(const Run& run, const HearingOptions& hearing = {});

}  // namespace ifa
