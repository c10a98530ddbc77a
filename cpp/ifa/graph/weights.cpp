#include "ifa/graph/weights.hpp"

#include <cmath>

namespace ifa {
namespace {

constexpr double kRounding = 1e-5;  // of an energy: its parts are kept as float32

}  // namespace

Mat3 smallest_turn(const Vec3& from, const Vec3& to) {
  const double cosine = from.dot(to);
  if (cosine < -1.0 + 1e-9) {  // half a turn, about any axis across
    const Vec3 helper = std::abs(from.x()) < 0.6 ? Vec3(Vec3::UnitX()) : Vec3(Vec3::UnitY());
    const Vec3 axis = from.cross(helper).normalized();
    return 2.0 * axis * axis.transpose() - Mat3::Identity();
  }
  const Mat3 w = cross_matrix(from.cross(to));
  return Mat3::Identity() + w + w * w / (1.0 + cosine);
}

Splice splice(const TakeOffView& i, const PlausibleRegion& region, const TakeOffView& j, double flight_s) {
  const Mat3 turn = smallest_turn(j.up, i.up);
  Splice s;
  s.velocity = turn * j.velocity + (j.height_m - i.height_m) / flight_s * i.up;
  s.spin = turn * j.spin;
  s.excess = region.excess(s.velocity - i.velocity, s.spin - i.spin);
  s.angle_rad = std::atan2(j.up.cross(i.up).norm(), j.up.dot(i.up));
  s.log_velocity = -s.excess;
  s.log_orientation = log_orientation_factor(s.angle_rad, flight_s);
  return s;
}

PlausibleRegion region_of(const Nodes& nodes, std::size_t i, const Body& body) {
  const float* c = nodes.change.data() + 6 * i;
  return {Vec3(c[0], c[1], c[2]), Vec3(c[3], c[4], c[5]), body.bounding_radius_m()};
}

double energy_j(const Body& body, double gravity_m_s2, const Vec3& velocity, const Vec3& spin,
                double height_m) {
  return 0.5 * (body.mass_kg() * velocity.squaredNorm() +
                spin.dot(body.principal_inertia().cwiseProduct(spin))) +
         body.mass_kg() * gravity_m_s2 * height_m;
}

double onset_energy_j(const Nodes& nodes, std::size_t i, const Body& body, double gravity_m_s2) {
  const State s = onset_of(nodes, i);
  return energy_j(body, gravity_m_s2, s.velocity, s.orientation.conjugate() * s.angular_velocity,
                  s.position.z());
}

bool keeps_energy(const Nodes& nodes, std::size_t i, std::size_t target, const Splice& s, const Body& body,
                  double gravity_m_s2, double gain_j) {
  const double blend = energy_j(body, gravity_m_s2, s.velocity, s.spin, nodes.take_off[10 * i + 9]);
  return blend <= nodes.energy_j[i] * (1.0 + kRounding) + gain_j &&
         onset_energy_j(nodes, target, body, gravity_m_s2) <= blend * (1.0 + kRounding) + gain_j;
}

}  // namespace ifa
