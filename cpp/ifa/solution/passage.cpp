#include "ifa/solution/passage.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "ifa/base/counted.hpp"

namespace ifa {
namespace {

constexpr double kContactMargin = 0.01;
constexpr int kMostImpacts =
    60;  // in one passage: chatter, which no viewer could follow, and each costs time

Hit hit_of(double time_s, const lanes::HitData& data) {
  return {time_s, Eigen::Map<const Vec3>(data.impulse), data.approach_speed,
          Eigen::Map<const Vec3>(data.position)};
}

}  // namespace

Listener::Listener(const SearchPhysics& physics, const Departure& departure)
    : physics_(&physics), event_only_(departure.event_only), event_(physics.hearing, departure.span_s) {
  event_.begin(departure.first);
}

bool Listener::begins_next(double time_s, double approach_speed_m_s) {
  const HearingOptions& hearing = physics_->hearing;
  if (impacts_ >= kMostImpacts) {
    dubious_ = true;
    return true;
  }
  const bool contact = hearing.events == Events::contact;
  if (!contact) {
    dubious_ |= std::abs(approach_speed_m_s / hearing.audible_speed_m_s - 1.0) < physics_->margin;
    if (approach_speed_m_s < hearing.audible_speed_m_s) return false;
  }
  // The end of a contact can be told sharply; a third of all motions have a flight within 5 % of the gap.
  const double margin = contact ? kContactMargin : physics_->margin;
  if (const auto gap = event_.judged_gap_s(time_s))
    dubious_ |= std::abs(*gap / hearing.merge_gap_s - 1.0) < margin;
  return !event_.chains(time_s);
}

void Listener::add(const Hit& hit) {
  ++impacts_;
  if (event_.audible(hit)) event_.add(hit);
}

Passage Listener::ended(Next next, double time_s, const State& end, double rest_s) {
  Passage passage;
  passage.next = dubious_ && (event_only_ || next != Next::late) ? Next::dubious : next;
  passage.interval_s = time_s;
  if (next == Next::rest) event_.clip(rest_s);
  passage.event = event_.event();
  passage.end = end;
  passage.rest_s = rest_s;
  return passage;
}

class Passages::Client {
 public:
  static constexpr bool kStrikesAtStart = false, kWantsLoads = true;

  Client(Passages& owner, std::span<const Departure> departures, std::span<Passage> out)
      : owner_(owner), departures_(departures), out_(out) {}

  bool begin(Member& m) {
    if (next_ == departures_.size()) return false;
    m.index = next_++;
    const Departure& departure = departures_[m.index];
    static_cast<lanes::Sim&>(m) =
        begin_sim(owner_.flock_.body(), owner_.flock_.settings(), departure.after, 0.0);
    m.until_s = departure.limit_s;
    m.listener.emplace(owner_.physics_, departure);
    return true;
  }

  bool loaded(Member& m, const lanes::LoadData& load) {
    m.listener->add(Load{load.begin_s, load.length_s, load.normal_impulse, load.slip_speed});
    // A ball that does not bounce any more only rolls on, and does not sound: no need to watch it.
    const Departure& departure = departures_[m.index];
    if (!owner_.ball_ || m.stage != lanes::Stage::contact || m.time_s <= departure.span_s) return true;
    const double rest_s = m.time_s + owner_.rolls_for_s(m);
    if (rest_s <= departure.limit_s)
      finish(m, m.listener->ended(Next::rest, m.time_s, state_of(m), rest_s));
    else
      finish(m, m.listener->ended(Next::late, departure.limit_s, state_of(m)));
    return false;
  }

  void impact(Member& m) { m.before = state_of(m); }

  bool resolved(Member& m, const lanes::HitData& data) {
    if (!m.listener->begins_next(m.time_s, data.approach_speed)) {
      m.listener->add(hit_of(m.time_s, data));
      if (departures_[m.index].event_only)
        m.until_s = std::max(m.until_s, m.time_s + owner_.physics_.event_over_s());
      return true;
    }
    Passage& passage = finish(m, m.listener->ended(Next::hit, m.time_s, m.before));
    passage.onset = {m.before, state_of(m), hit_of(0.0, data)};
    return false;
  }

  void ended(Member& m, lanes::Stop stop) {
    const bool rest = stop == lanes::Stop::rest && stands(owner_.body_, state_of(m));
    // Where contact is not followed, only of a ball it is known what comes of it: nothing.
    const bool unknown = stop == lanes::Stop::contact && !owner_.ball_;
    finish(m, m.listener->ended(rest      ? Next::rest
                                : unknown ? Next::dubious
                                          : Next::late,
                                m.time_s, state_of(m), rest ? m.slow_since_s : 0.0));
  }

 private:
  Passage& finish(const Member& m, const Passage& passage) {
    owner_.simulated_s_ += passage.interval_s;
    return out_[m.index] = passage;
  }

  Passages& owner_;
  std::span<const Departure> departures_;
  std::span<Passage> out_;
  std::size_t next_ = 0;
};

Passages::Passages(const Body& body, const SearchPhysics& physics)
    : body_(body),
      physics_(physics),
      kernels_(*lanes::available_kernels().back()),
      flock_(body, physics.simulation, kernels_),
      dull_(view_of(body)) {
  dull_.restitution = 0.0;
  ball_ = physics.hearing.events == Events::audible && is_ball(body);
}

// How long a ball in contact rolls, slips and spins on, at most.
double Passages::rolls_for_s(const lanes::Sim& sim) const {
  const lanes::BodyView& ball = flock_.body();
  const double g = physics_.simulation.gravity_m_s2.norm(), inertia = ball.inertia[0];
  const double roll =
      std::hypot(sim.velocity[0], sim.velocity[1]) + ball.rounding * std::hypot(sim.spin[0], sim.spin[1]);
  const double slowing = ball.rolling_friction_m * g /
                         (ball.rounding * (1.0 + inertia / (ball.mass * ball.rounding * ball.rounding)));
  const double spin_slowing = ball.spin_friction_m * ball.mass * g / inertia;
  return std::max(roll / slowing, std::abs(sim.spin[2]) / spin_slowing);
}

void Passages::run(std::span<const Departure> departures, std::span<Passage> out, const Progress* progress) {
  Client client(*this, departures, out);
  flock_.run(client, progress);
}

void Passages::strike(std::span<const State> before, std::span<Onset> out) {
  constexpr std::size_t kWidest = 8;
  const std::size_t width = static_cast<std::size_t>(kernels_.width);
  for (std::size_t from = 0; from < before.size(); from += width) {
    std::array<lanes::Sim, kWidest> sims;
    std::array<lanes::Sim*, kWidest> pointers;
    std::array<lanes::HitData, kWidest> hits;
    const std::size_t count = std::min(width, before.size() - from);
    for (std::size_t i = 0; i < count; ++i) {
      sims[i] = begin_sim(flock_.body(), flock_.settings(), before[from + i], 0.0);
      pointers[i] = &sims[i];
    }
    kernels_.resolve(flock_.body(), flock_.settings(), pointers.data(), static_cast<int>(count), hits.data());
    for (std::size_t i = 0; i < count; ++i)
      out[from + i] = {before[from + i], state_of(sims[i]), hit_of(0.0, hits[i])};
  }
}

bool Passages::settle(State& state) const {
  lanes::Sim sim = begin_sim(dull_, flock_.settings(), state, 0.0);
  constexpr double kRounding = 1e-9;  // m/s
  if (lanes::kScalarKernels.separation_speed(dull_, sim) >= -kRounding) return false;
  lanes::Sim* const sims[1] = {&sim};
  lanes::HitData hit;
  lanes::kScalarKernels.resolve(dull_, flock_.settings(), sims, 1, &hit);
  state = state_of(sim);
  return true;
}

bool is_ball(const Body& body) {
  constexpr double kCentred = 1e-12;
  return body.isotropic() && body.rings().empty() && body.vertices().size() == 1 &&
         body.vertices().front().norm() <= kCentred * body.radius_m();
}

bool stands(const Body& body, const State& at_rest) {
  constexpr double kTouchShare =
      1e-3;  // of the size: far above a face's vertices at rest, far below other ones
  const auto& vertices = body.principal_vertices();
  if (!body.rings().empty() || vertices.size() < 3) return true;
  const Vec3 up = at_rest.orientation.conjugate() * kUp;
  double lowest = kNever;
  for (const Vec3& v : vertices) lowest = std::min(lowest, up.dot(v));
  const double touch = lowest + kTouchShare * body.bounding_radius_m();
  return std::ranges::count_if(vertices, [&](const Vec3& v) { return up.dot(v) <= touch; }) >= 3;
}

Passage record_passage(const Body& body, const SearchPhysics& physics, const Departure& departure,
                       Record& record, const Progress* progress) {
  Listener listener(physics, departure);
  EventSimulation simulation(body, physics.simulation);
  simulation.start(departure.after, 0.0, &record.nodes, &record.loads, progress);
  std::size_t heard = record.loads.size();
  for (;;) {
    const auto stop = simulation.advance(departure.limit_s);
    for (; heard < record.loads.size(); ++heard) listener.add(record.loads[heard]);
    const double now = simulation.time_s();
    if (stop == EventSimulation::Stop::rest && stands(body, simulation.state()))
      return listener.ended(Next::rest, now, simulation.state(), simulation.rest_s());
    if (stop != EventSimulation::Stop::impact) return listener.ended(Next::late, now, simulation.state());
    if (listener.begins_next(now, simulation.approach_speed()))
      return listener.ended(Next::hit, now, simulation.state());
    const Hit hit = simulation.resolve();
    listener.add(hit);
    record.hits.push_back(hit);
  }
}

Onset strike(const Body& body, const SearchPhysics& physics, const State& before) {
  EventSimulation simulation(body, physics.simulation);
  simulation.start(before, 0.0);
  const Hit hit = simulation.resolve();
  return {before, simulation.state(), hit};
}

const State& state_before_last_flight(const Record& record) {
  const std::vector<Node>& nodes = record.nodes;
  const std::size_t last = nodes.size() - 1;
  return nodes[last > 0 && nodes[last - 1].time_s == nodes[last].time_s ? last - 1 : last].state;
}

double clear_before(const Body& body, const State& first, const Vec3& gravity_m_s2, double limit_s) {
  count_run(Effect::pre_roll_flight);
  State reversed = first;
  reversed.velocity = -first.velocity;
  reversed.angular_velocity = -first.angular_velocity;
  Flight flight(body);
  flight.start(reversed, gravity_m_s2);
  return std::min(flight.next_contact(limit_s), limit_s);
}

}  // namespace ifa
