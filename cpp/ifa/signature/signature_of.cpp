#include "ifa/signature/signature_of.hpp"

#include <limits>
#include <string>

#include "ifa/base/error.hpp"
#include "ifa/base/message.hpp"

namespace ifa {

Marks signature_of(const Run& run, const HearingOptions& hearing) {
  Marks marks;
  const auto mark = [&marks](const Event& event) {
    marks.times_s.push_back(event.time_s);
    marks.durations_s.push_back(event.length_s);
    marks.amplitudes.push_back(event.amplitude);
    marks.centroids_s.push_back(event.length_s > 0.0 ? event.centroid_s
                                                     : std::numeric_limits<double>::quiet_NaN());
  };
  EventBuilder builder(hearing, 0.0);
  bool begun = false;
  for (const Hit& hit : run.hits) {
    if (!builder.audible(hit)) continue;
    if (begun && builder.chains(hit.time_s)) {
      builder.add(hit);
      continue;
    }
    if (begun) mark(builder.event());
    builder.begin(hit);
    begun = true;
  }
  if (!begun)
    throw ArgumentError("run: none of its " + std::to_string(run.hits.size()) +
                        " hits is audible, which takes an approach at " + number(hearing.audible_speed_m_s) +
                        " m/s");
  mark(builder.event());
  marks.ending = run.status == RunStatus::rest ? Ending::rest : Ending::open;
  return marks;
}

}  // namespace ifa
