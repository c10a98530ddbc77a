#include "ifa/rigid/near_points.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

namespace ifa {
namespace {

const Vec3 kDirection(0.61803398874989485, 0.27182818284590452, 0.73766078095598140);

}  // namespace

NearPoints::NearPoints(std::vector<Vec3> points) : points_(std::move(points)), order_(points_.size()) {
  std::vector<double> along(points_.size());
  for (std::size_t i = 0; i < along.size(); ++i) along[i] = kDirection.dot(points_[i]);
  std::iota(order_.begin(), order_.end(), 0);
  std::sort(order_.begin(), order_.end(),
            [&](int a, int b) { return along[a] != along[b] ? along[a] < along[b] : a < b; });
  for (const int i : order_) along_.push_back(along[i]);
  if (along_.empty()) return;
  low_ = along_.front();
  const double length = along_.back() - low_;
  const std::size_t buckets = along_.size();
  per_length_ = length > 0.0 ? static_cast<double>(buckets) / length : 0.0;
  start_.assign(buckets + 1, along_.size());
  for (std::size_t i = along_.size(); i-- > 0;) start_[bucket(along_[i])] = i;
  for (std::size_t b = buckets; b-- > 0;) start_[b] = std::min(start_[b], start_[b + 1]);
}

std::size_t NearPoints::bucket(double along) const {
  const double b = (along - low_) * per_length_, last = static_cast<double>(start_.size() - 2);
  return static_cast<std::size_t>(std::clamp(b, 0.0, last));
}

int NearPoints::first_within(const Vec3& p, double distance) const {
  if (points_.empty()) return -1;
  const double along = kDirection.dot(p);
  int first = -1;
  // the direction is no longer than 1, so nothing within the distance is further along it
  for (std::size_t i = start_[bucket(along - distance)]; i < along_.size(); ++i) {
    if (along_[i] > along + distance) break;
    if ((first < 0 || order_[i] < first) && (points_[order_[i]] - p).squaredNorm() <= distance * distance)
      first = order_[i];
  }
  return first;
}

}  // namespace ifa
