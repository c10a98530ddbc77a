#include "ifa/graph/harvest.hpp"

#include <optional>

#include "ifa/rigid/contact.hpp"

namespace ifa {
namespace {

double energy_j(const Body& body, double gravity, const State& s) {
  return kinetic_energy(body, s) + body.mass_kg() * gravity * s.position.z();
}

struct Sample : lanes::Sim {
  std::size_t index;  // of the simulation in its chunk
  std::optional<Listener> listener;
  State before;  // the impact that is being resolved
  State onset_before, onset_after;
  State take_off;  // after the last contact
  double take_off_s = 0.0, energy_j = 0.0;
  bool flew = false;  // from there to the impact that is being resolved
  NodeColumns nodes;
};

class Harvester {
 public:
  static constexpr bool kStrikesAtStart = true, kWantsLoads = true;

  Harvester(Flock<Sample>& flock, const Body& body, const SearchPhysics& physics,
            std::span<const State> states, std::uint64_t first, double until_s, std::span<NodeColumns> out)
      : flock_(flock),
        body_(body),
        physics_(physics),
        gravity_(physics.simulation.gravity_m_s2.norm()),
        states_(states),
        first_(first),
        until_s_(until_s),
        out_(out) {}

  bool begin(Sample& m) {
    if (next_ == states_.size()) return false;
    m.index = next_++;
    static_cast<lanes::Sim&>(m) = begin_sim(flock_.body(), flock_.settings(), states_[m.index], 0.0);
    m.until_s = until_s_;
    m.listener.reset();
    m.nodes = {};
    return true;
  }

  void impact(Sample& m) {
    m.before = state_of(m);
    m.flew = m.stage == lanes::Stage::flight;
  }

  bool resolved(Sample& m, const lanes::HitData& data) {
    Hit hit{m.time_s, Eigen::Map<const Vec3>(data.impulse), data.approach_speed,
            Eigen::Map<const Vec3>(data.position)};
    const bool onset = m.listener ? m.listener->begins_next(m.time_s, data.approach_speed)
                                  : data.approach_speed >= physics_.least_onset_speed_m_s();
    if (onset) {
      if (m.listener) close(m, Next::hit);
      hit.time_s = 0.0;
      m.onset_before = m.before;
      begin_anew(m);
      m.listener.emplace(physics_, Departure{hit, m.onset_after, 0.0, kNever});
    } else if (m.listener) {
      m.listener->add(hit);
    }
    touched(m, m.before);
    return true;
  }

  bool loaded(Sample& m, const lanes::LoadData& load) {
    if (m.listener) m.listener->add(Load{load.begin_s, load.length_s, load.normal_impulse, load.slip_speed});
    touched(m, state_of(m));
    return true;
  }

  void ended(Sample& m, lanes::Stop stop) {
    const bool rest = stop == lanes::Stop::rest && stands(body_, state_of(m));
    if (m.listener) close(m, rest ? Next::rest : Next::late, m.slow_since_s);
    out_[m.index] = std::move(m.nodes);
  }

 private:
  // From just after an onset on the simulation goes as if it began there, so that the edge can be simulated
  // again from what the node holds, to the last bit.
  void begin_anew(Sample& m) {
    m.onset_after = state_of(m);
    m.onset_after.position.x() = m.onset_after.position.y() = 0.0;
    const double left_s = m.until_s - m.time_s;
    static_cast<lanes::Sim&>(m) = begin_sim(flock_.body(), flock_.settings(), m.onset_after, 0.0);
    m.until_s = left_s;
  }

  void touched(Sample& m, const State& before) {
    m.take_off = state_of(m);
    m.take_off_s = m.time_s;
    m.energy_j = energy_j(body_, gravity_, before);
  }

  // The event that went on until now is a node.
  void close(Sample& m, Next next, double rest_s = 0.0) {
    const Passage passage = m.listener->ended(next, m.time_s, state_of(m), rest_s);
    NodeColumns& c = m.nodes;
    const auto put = [](auto& column, const Vec3& v) {
      for (int i = 0; i < 3; ++i)
        column.push_back(static_cast<typename std::decay_t<decltype(column)>::value_type>(v[i]));
    };
    const State& s = m.onset_after;
    const Quat& q = s.orientation;
    c.onset.insert(c.onset.end(), {s.position.z(), q.w(), q.x(), q.y(), q.z()});
    put(c.onset, s.velocity);
    put(c.onset, s.angular_velocity);
    const TakeOffView off = take_off_of(m.take_off);
    put(c.take_off, off.up);
    put(c.take_off, off.velocity);
    put(c.take_off, off.spin);
    c.take_off.push_back(static_cast<float>(off.height_m));
    const Quat to_body = m.take_off.orientation.conjugate();
    put(c.change, to_body * (m.take_off.velocity - m.onset_before.velocity));
    put(c.change, to_body * (m.take_off.angular_velocity - m.onset_before.angular_velocity));
    const bool flight = next == Next::hit && m.flew;
    const double delay_s = flight ? m.take_off_s : m.time_s;
    c.delay_s.push_back(static_cast<float>(delay_s));
    c.flight_s.push_back(flight ? static_cast<float>(m.time_s - delay_s) : 0.0f);
    c.energy_j.push_back(static_cast<float>(m.energy_j));
    c.amplitude.push_back(static_cast<float>(passage.event.amplitude));
    c.length_s.push_back(static_cast<float>(passage.event.length_s));
    c.centroid_s.push_back(static_cast<float>(passage.event.centroid_s));
    c.simulation.push_back(static_cast<std::uint32_t>(first_ + m.index));
    c.flags.push_back(static_cast<std::uint8_t>((next == Next::hit ? kEdge : 0) |
                                                (next == Next::rest ? kTerminal : 0) |
                                                (passage.next == Next::dubious ? kDubious : 0)));
  }

  Flock<Sample>& flock_;
  const Body& body_;
  const SearchPhysics& physics_;
  double gravity_;
  std::span<const State> states_;
  std::uint64_t first_;
  double until_s_;
  std::span<NodeColumns> out_;
  std::size_t next_ = 0;
};

}  // namespace

NodeColumns harvest(const Body& body, const SearchPhysics& physics, const SamplingOptions& sampling,
                    std::uint64_t seed, std::uint64_t first, std::size_t count, double until_s,
                    const Progress* progress) {
  std::vector<State> states(count);
  sample_states(body, sampling, seed, first, states, 1, progress);
  std::vector<NodeColumns> each(count);
  Flock<Sample> flock(body, physics.simulation, *lanes::available_kernels().back());
  Harvester harvester(flock, body, physics, states, first, until_s, each);
  flock.run(harvester, progress);
  NodeColumns all;
  for (const NodeColumns& c : each) append(all, c);
  return all;
}

}  // namespace ifa
