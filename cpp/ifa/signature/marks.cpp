#include "ifa/signature/marks.hpp"

#include <cmath>
#include <string>

#include "ifa/base/error.hpp"
#include "ifa/base/message.hpp"

namespace ifa {
namespace {

// Marks typed as decimals, such as 0.60 and 0.61, are 10 ms apart only up to the rounding of binary
// fractions; a nanosecond is far above that and far below what anyone can mark.
constexpr double kRounding_s = 1e-9;

void check_length(const std::vector<double>& values, const char* field, std::size_t n) {
  if (values.size() == n) return;
  throw ArgumentError(std::string(field) + ": needs one value for each of the " + std::to_string(n) +
                      " marks, got " + std::to_string(values.size()));
}

void check_time(const Marks& marks, std::size_t k, double merge_gap_s) {
  const double time_s = marks.times_s[k];
  const std::string name = mark_name(k, time_s);
  if (!std::isfinite(time_s)) throw ArgumentError(name + ": its time is not finite");
  if (time_s < 0.0) throw ArgumentError(name + ": lies before the start of the sound");
  if (k == 0) return;
  const double before_s = marks.times_s[k - 1];
  const std::string before = mark_name(k - 1, before_s);
  if (time_s < before_s)
    throw ArgumentError(name + " comes before " + before + ": marks go in order of time");
  if (time_s == before_s) throw ArgumentError(name + " is at the same time as " + before);
  if (time_s - before_s < merge_gap_s - kRounding_s)
    throw ArgumentError(name + " is only " + number(1e3 * (time_s - before_s)) + " ms after " + before +
                        ": contacts closer than " + number(1e3 * merge_gap_s) + " ms are one event");
  const double end_s = before_s + marks.durations_s[k - 1];
  if (time_s < end_s - kRounding_s)
    throw ArgumentError(name + " starts inside the span of " + before + ", which ends at " + seconds(end_s));
}

}  // namespace

void validate(const Marks& marks, double merge_gap_s) {
  if (!(std::isfinite(merge_gap_s) && merge_gap_s >= 0.0))
    throw ArgumentError("merge_gap_s: must be finite and not negative, got " + number(merge_gap_s));
  const std::size_t n = marks.size();
  if (n == 0) throw ArgumentError("times_s: there are no marks; at least one is needed");
  check_length(marks.durations_s, "durations_s", n);
  check_length(marks.centroids_s, "centroids_s", n);
  if (!marks.amplitudes.empty()) check_length(marks.amplitudes, "amplitudes", n);

  for (std::size_t k = 0; k < n; ++k) {
    check_time(marks, k, merge_gap_s);
    const std::string name = mark_name(k, marks.times_s[k]);
    const double duration_s = marks.durations_s[k];
    if (!std::isfinite(duration_s)) throw ArgumentError(name + ": its duration is not finite");
    if (duration_s < 0.0)
      throw ArgumentError(name + ": its duration " + seconds(duration_s) + " is negative");
    if (!marks.amplitudes.empty()) {
      const double amplitude = marks.amplitudes[k];
      if (!std::isfinite(amplitude)) throw ArgumentError(name + ": its amplitude is not finite");
      if (amplitude < 0.0)
        throw ArgumentError(name + ": its amplitude " + number(amplitude) + " is negative");
      if (k == 0 && amplitude == 0.0)
        throw ArgumentError(name + ": its amplitude is 0, but all others are relative to it");
    }
    const double centroid_s = marks.centroids_s[k];
    if (std::isnan(centroid_s)) continue;
    if (!(centroid_s >= 0.0 && centroid_s <= duration_s + kRounding_s))
      throw ArgumentError(name + ": its centroid " + seconds(centroid_s) + " lies outside its span of " +
                          seconds(duration_s));
  }
  validate_constraints(marks);
}

}  // namespace ifa
