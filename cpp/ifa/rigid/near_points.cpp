#include "ifa/rigid/near_points.hpp"

#include <algorithm>

namespace ifa {
namespace {

const Vec3 kDirection(0.61803398874989485, 0.27182818284590452, 0.73766078095598140);

}  // namespace

NearPoints::NearPoints(const std::vector<Vec3>& points) {
  for (const Vec3& p : points) places_.push_back({kDirection.dot(p), static_cast<int>(places_.size()), p});
  if (places_.empty()) return;
  std::stable_sort(places_.begin(), places_.end(),
                   [](const Place& a, const Place& b) { return a.along < b.along; });
  low_ = places_.front().along;
  const double length = places_.back().along - low_;
  const std::size_t buckets = places_.size();
  per_length_ = length > 0.0 ? static_cast<double>(buckets) / length : 0.0;
  start_.assign(buckets + 1, places_.size());
  for (std::size_t i = places_.size(); i-- > 0;) start_[bucket(places_[i].along)] = i;
  for (std::size_t b = buckets; b-- > 0;) start_[b] = std::min(start_[b], start_[b + 1]);
}

std::size_t NearPoints::bucket(double along) const {
  const double b = (along - low_) * per_length_, last = static_cast<double>(start_.size() - 2);
  return static_cast<std::size_t>(std::clamp(b, 0.0, last));
}

int NearPoints::first_within(const Vec3& p, double distance) const {
  if (places_.empty()) return -1;
  const double along = kDirection.dot(p);
  int first = -1;
  // the direction is of unit length, so nothing within the distance is further along it
  for (std::size_t i = start_[bucket(along - distance)]; i < places_.size(); ++i) {
    const Place& place = places_[i];
    if (place.along > along + distance) break;
    if ((first < 0 || place.index < first) && (place.point - p).squaredNorm() <= distance * distance)
      first = place.index;
  }
  return first;
}

}  // namespace ifa
