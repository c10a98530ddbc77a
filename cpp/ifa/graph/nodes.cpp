#include "ifa/graph/nodes.hpp"

namespace ifa {

Nodes view_of(const NodeColumns& c) {
  return {c.onset,     c.take_off, c.change,     c.delay_s,    c.flight_s, c.energy_j,
          c.amplitude, c.length_s, c.centroid_s, c.simulation, c.flags};
}

void append(NodeColumns& to, const NodeColumns& from) {
  const auto add = [](auto& a, const auto& b) { a.insert(a.end(), b.begin(), b.end()); };
  add(to.onset, from.onset);
  add(to.take_off, from.take_off);
  add(to.change, from.change);
  add(to.delay_s, from.delay_s);
  add(to.flight_s, from.flight_s);
  add(to.energy_j, from.energy_j);
  add(to.amplitude, from.amplitude);
  add(to.length_s, from.length_s);
  add(to.centroid_s, from.centroid_s);
  add(to.simulation, from.simulation);
  add(to.flags, from.flags);
}

State onset_of(const Nodes& nodes, std::size_t i) {
  const double* row = nodes.onset.data() + 11 * i;
  State s;
  s.position = {0.0, 0.0, row[0]};
  s.orientation = Quat(row[1], row[2], row[3], row[4]);
  s.velocity = {row[5], row[6], row[7]};
  s.angular_velocity = {row[8], row[9], row[10]};
  return s;
}

TakeOffView take_off_of(const Nodes& nodes, std::size_t i) {
  const float* row = nodes.take_off.data() + 10 * i;
  return {{row[0], row[1], row[2]}, {row[3], row[4], row[5]}, {row[6], row[7], row[8]}, row[9]};
}

TakeOffView take_off_of(const State& s) {
  const Quat to_body = s.orientation.conjugate();
  return {to_body * kUp, to_body * s.velocity, to_body * s.angular_velocity, s.position.z()};
}

}  // namespace ifa
