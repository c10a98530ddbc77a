#include "ifa/graph/replay.hpp"

#include <algorithm>
#include <string>

#include "ifa/base/error.hpp"
#include "ifa/base/message.hpp"

namespace ifa {
namespace {

std::string node_name(const Database& database, std::size_t i) {
  return database.folder().string() + ": node " + std::to_string(i) + " (simulation " +
         std::to_string(database.nodes().simulation[i]) + ")";
}

void need_node(const Database& database, std::size_t i) {
  if (i >= database.nodes().size())
    throw ArgumentError("node: there are " + std::to_string(database.nodes().size()) + ", from 0, not " +
                        std::to_string(i));
}

[[noreturn]] void refuse(const Database& database, std::size_t i, const std::string& what) {
  throw ReplayError(
      node_name(database, i) + ": simulated again, " + what +
      ": the database was built by another version of ifa or on another processor, or is damaged");
}

void need_onset(const Database& database, std::size_t edge, std::size_t i, const State& after) {
  const double apart = state_difference(database.body(), after, onset_of(database.nodes(), i));
  if (!(apart <= kReplayTolerance))
    refuse(database, edge, "it differs by " + number(apart) + " at the onset of node " + std::to_string(i));
}

// The impact that a simulation's first event begins with.
Onset first_onset(const Database& database, std::size_t i, const Progress* progress) {
  const Recipe& recipe = database.recipe();
  State start[1];
  sample_states(database.body(), recipe.sampling, recipe.seed, database.nodes().simulation[i], start, 1);
  EventSimulation simulation(database.body(), recipe.physics.simulation);
  simulation.start(start[0], 0.0, nullptr, nullptr, progress);
  bool strikes = simulation.approach_speed() > 0.0;  // at once
  while (strikes || simulation.advance(recipe.until_s) == EventSimulation::Stop::impact) {
    strikes = false;
    Onset onset;
    onset.before = simulation.state();
    onset.hit = simulation.resolve();
    onset.hit.time_s = 0.0;
    onset.after = simulation.state();
    if (onset.hit.approach_speed_m_s >= recipe.physics.least_onset_speed_m_s()) return onset;
  }
  refuse(database, i, "its simulation has no event");
}

}  // namespace

double state_difference(const Body& body, const State& a, const State& b) {
  const double radius = body.bounding_radius_m();
  const auto speed = [&](const State& s) { return s.velocity.norm() + radius * s.angular_velocity.norm(); };
  const double fastest = std::max({speed(a), speed(b), std::numeric_limits<double>::min()});
  return std::max({std::abs(a.position.z() - b.position.z()) / radius,
                   2.0 * (a.orientation.conjugate() * b.orientation).vec().norm(),
                   (a.velocity - b.velocity).norm() / fastest,
                   radius * (a.angular_velocity - b.angular_velocity).norm() / fastest});
}

Passage replay_edge(const Database& database, std::size_t i, Record& record, const Progress* progress) {
  need_node(database, i);
  const Nodes& nodes = database.nodes();
  const bool edge = (nodes.flags[i] & kEdge) != 0, terminal = (nodes.flags[i] & kTerminal) != 0;
  if (!edge && !terminal)
    throw ArgumentError("node: nothing follows node " + std::to_string(i) +
                        ": its simulation ended before rest");
  if (edge && (i + 1 >= nodes.size() || nodes.simulation[i + 1] != nodes.simulation[i]))
    throw FileError(node_name(database, i) + ": is damaged: the next node is of another simulation");
  const Departure departure{Hit{}, onset_of(nodes, i), 0.0, database.recipe().until_s};
  Passage passage = record_passage(database.body(), database.physics(), departure, record, progress);
  if (passage.next == Next::late) refuse(database, i, "nothing comes after it");
  if (edge) {
    passage.onset = strike(database.body(), database.physics(), passage.end);
    need_onset(database, i, i + 1, passage.onset.after);
  } else if (passage.next == Next::hit) {
    refuse(database, i, "it does not come to rest");
  }
  // The impulse of its first impact is not stored, but what the event amounts to is.
  passage.event.amplitude = static_cast<double>(nodes.amplitude[i]);
  passage.event.length_s = static_cast<double>(nodes.length_s[i]);
  passage.event.centroid_s = static_cast<double>(nodes.centroid_s[i]);
  return passage;
}

Onset replay_onset(const Database& database, std::size_t i, const Progress* progress) {
  need_node(database, i);
  const Nodes& nodes = database.nodes();
  if (i > 0 && nodes.simulation[i - 1] == nodes.simulation[i]) {
    Record record;
    return replay_edge(database, i - 1, record, progress).onset;
  }
  const Onset onset = first_onset(database, i, progress);
  need_onset(database, i, i, onset.after);
  return onset;
}

}  // namespace ifa
