#include "ifa/signature/factors.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "ifa/base/counted.hpp"

namespace ifa {
namespace {

// Paper section 5.4.
constexpr double kThetaLinear = 20.0 * std::numbers::pi / 180.0;
constexpr double kThetaAngular = 10.0 * std::numbers::pi / 180.0;
constexpr double kPhiLinear = 0.4;
constexpr double kPhiAngular = 0.2;
constexpr double kOrientation = 0.85;  // c_q; with T_0: halfwidth 0.9 rad/s, about 10 degrees
constexpr double kTime = 100.0;        // c_t, halfwidth 7 % retiming
constexpr double kAmplitude = 2.78;    // c_a, halfwidth 0.5
constexpr double kDuration = 7000.0;   // c_Delta, halfwidth 10 ms

constexpr double kLeastChange = 0.01;  // m/s

// Half axes along `change` and across it: phi |change| and phi |change| tan(theta) (eq. 2).
Mat3 half_axes(const Vec3& change, double least, double phi, double theta) {
  const double size = std::max(change.norm(), least);
  const Vec3 along = change.norm() > 0.0 ? Vec3(change.normalized()) : kUp;
  const Vec3 helper = std::abs(along.z()) < 0.9 ? Vec3(kUp) : Vec3(Vec3::UnitX());
  const Vec3 side = along.cross(helper).normalized();
  Mat3 axes;
  axes.col(0) = phi * size * along;
  axes.col(1) = phi * size * std::tan(theta) * side;
  axes.col(2) = phi * size * std::tan(theta) * along.cross(side);
  return axes;
}

double safe_log(double factor) { return std::log(std::max(factor, 1e-300)); }

}  // namespace

PlausibleRegion::PlausibleRegion(const Vec3& velocity_change, const Vec3& spin_change, double radius_m)
    : linear_(half_axes(velocity_change, kLeastChange, kPhiLinear, kThetaLinear)),
      angular_(half_axes(spin_change, kLeastChange / radius_m, kPhiAngular, kThetaAngular)) {}

Vec6 PlausibleRegion::coordinates(const Vec3& velocity_offset, const Vec3& spin_offset) const {
  Vec6 y;  // the columns are orthogonal: a coordinate is a projection over the squared half axis
  for (int i = 0; i < 3; ++i) {
    y[i] = linear_.col(i).dot(velocity_offset) / linear_.col(i).squaredNorm();
    y[3 + i] = angular_.col(i).dot(spin_offset) / angular_.col(i).squaredNorm();
  }
  return y;
}

double PlausibleRegion::excess(const Vec3& velocity_offset, const Vec3& spin_offset) const {
  return coordinates(velocity_offset, spin_offset).squaredNorm();
}

double velocity_factor(double excess) { return std::exp(-excess); }

double log_orientation_factor(double angle_rad, double flight_s) {
  const double rate = angle_rad / std::min(flight_s, kShortFlight_s);
  return -kOrientation * rate * rate;
}

double log_time_factor(double interval_s, double target_s) {
  const double retiming = std::max(interval_s, target_s) / std::min(interval_s, target_s) - 1.0;
  return -kTime * retiming * retiming;
}

double log_amplitude_factor(double amplitude, double target) {
  return -kAmplitude * (amplitude - target) * (amplitude - target);
}

double log_length_factor(double length_s, double target_s) {
  return -kDuration * (length_s - target_s) * (length_s - target_s);
}

double time_factor(double interval_s, double target_s) {
  return std::exp(log_time_factor(interval_s, target_s));
}
double amplitude_factor(double amplitude, double target) {
  return std::exp(log_amplitude_factor(amplitude, target));
}
double length_factor(double length_s, double target_s) {
  return std::exp(log_length_factor(length_s, target_s));
}
double centroid_factor(double centroid_s, double target_s) {
  return std::exp(log_length_factor(centroid_s, target_s));
}

Factors sound_factors(const Event& event, const Marks& marks, std::size_t k, double first_amplitude,
                      const SoundTerms& judged) {
  Factors f;
  if (judged.amplitude && !marks.amplitudes.empty() && k > 0) {
    count_run(Effect::amplitude_matching);
    f.amplitude =
        amplitude_factor(event.amplitude / first_amplitude, marks.amplitudes[k] / marks.amplitudes[0]);
  }
  const double duration_s = marks.durations_s[k];
  if (duration_s == 0.0) {
    if (event.length_s > 0.0) f.length = length_factor(event.length_s, 0.0);
    return f;
  }
  if (judged.length) {
    count_run(Effect::length_matching);
    f.length = length_factor(event.length_s, duration_s);
  }
  if (judged.centroid && !std::isnan(marks.centroids_s[k])) {
    count_run(Effect::centroid_matching);
    f.centroid = centroid_factor(event.centroid_s, marks.centroids_s[k]);
  }
  return f;
}

double log_product(const Factors& f) {
  return safe_log(f.velocity) + safe_log(f.orientation) + safe_log(f.time) + safe_log(f.amplitude) +
         safe_log(f.length) + safe_log(f.centroid);
}

double score(const std::vector<Factors>& factors) {
  double sum = 0.0;
  for (const Factors& f : factors) sum += log_product(f);
  return std::exp(sum / (6.0 * static_cast<double>(factors.size())));
}

double score_without_sound(const std::vector<Factors>& factors) {
  double sum = 0.0;
  for (const Factors& f : factors) sum += safe_log(f.velocity) + safe_log(f.orientation) + safe_log(f.time);
  return std::exp(sum / (3.0 * static_cast<double>(factors.size())));
}

}  // namespace ifa
