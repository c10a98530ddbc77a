#include "ifa/sound/envelope.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "ifa/base/error.hpp"
#include "ifa/base/message.hpp"

namespace ifa {
namespace {

// Samples first..end - 1.
struct Range {
  std::size_t first, end;
};

// The samples at or after `start_s` and before `end_s`; at least one. start_s lies inside the sound.
Range samples_between(const Sound& sound, double start_s, double end_s) {
  // a time that stands for a whole sample, such as 0.0125 s at 48 kHz, may exceed it by rounding
  const auto index = [&](double time_s) {
    const double count = static_cast<double>(sound.samples.size());
    return static_cast<std::size_t>(std::clamp(std::ceil(time_s * sound.sample_rate_hz - 1e-6), 0.0, count));
  };
  const std::size_t first = std::min(index(start_s), sound.samples.size() - 1);
  return {first, std::max(first + 1, index(end_s))};
}

double peak(const Sound& sound, Range range) {
  double largest = 0.0;
  for (std::size_t i = range.first; i < range.end; ++i)
    largest = std::max(largest, std::abs(static_cast<double>(sound.samples[i])));
  return largest;
}

// tau of paper eq. 8, from start_s.
double centroid(const Sound& sound, Range range, double start_s, double duration_s) {
  const auto bin_samples = std::max<std::size_t>(1, std::lround(kEnvelopeBin_s * sound.sample_rate_hz));
  double weighted = 0.0, total = 0.0;
  for (std::size_t i = range.first; i < range.end; i += bin_samples) {
    const std::size_t end = std::min(i + bin_samples, range.end);
    double energy = 0.0;
    for (std::size_t j = i; j < end; ++j) energy += static_cast<double>(sound.samples[j]) * sound.samples[j];
    const double count = static_cast<double>(end - i);  // the last bin may be shorter
    const double weight = count * std::sqrt(energy / count);
    const double middle_s = 0.5 * static_cast<double>(i + end - 1) / sound.sample_rate_hz;
    weighted += weight * (middle_s - start_s);
    total += weight;
  }
  if (total == 0.0) return std::numeric_limits<double>::quiet_NaN();
  return std::clamp(weighted / total, 0.0, duration_s);  // a span shorter than a sample holds none
}

}  // namespace

MarkAmplitudes mark_amplitudes(const Sound& sound, const std::vector<double>& times_s,
                               const std::vector<double>& durations_s) {
  const std::size_t n = times_s.size();
  if (durations_s.size() != n)
    throw ArgumentError("durations_s: needs one value for each of the " + std::to_string(n) + " marks, got " +
                        std::to_string(durations_s.size()));
  const double sound_s = sound.duration_s();
  MarkAmplitudes result;
  for (std::size_t k = 0; k < n; ++k) {
    const double time_s = times_s[k], duration_s = durations_s[k];
    const std::string name = mark_name(k, time_s);
    if (!(time_s >= 0.0 && time_s < sound_s))
      throw ArgumentError(name + ": lies outside the sound, which is " + seconds(sound_s) + " long");
    if (!(duration_s >= 0.0 && time_s + duration_s <= sound_s + kPeakWindow_s))
      throw ArgumentError(name + ": its span ends at " + seconds(time_s + duration_s) +
                          ", after the sound, which is " + seconds(sound_s) + " long");
    double end_s = time_s + duration_s;
    if (duration_s == 0.0) {
      end_s = time_s + kPeakWindow_s;
      if (k + 1 < n) end_s = std::min(end_s, 0.5 * (time_s + times_s[k + 1]));
    }
    const Range range = samples_between(sound, time_s, end_s);
    const double amplitude = peak(sound, range);
    if (k == 0 && amplitude == 0.0)
      throw ArgumentError(name + ": the sound is silent there, but all amplitudes are relative to the first");
    result.amplitudes.push_back(amplitude);
    result.centroids_s.push_back(duration_s > 0.0 ? centroid(sound, range, time_s, duration_s)
                                                  : std::numeric_limits<double>::quiet_NaN());
  }
  return result;
}

}  // namespace ifa
