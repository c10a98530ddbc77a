// The nodes of a contact-event graph as columns: one for each event of each simulation (paper section 5.2).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "ifa/rigid/state.hpp"

namespace ifa {

// What is known of a node.
enum NodeFlag : std::uint8_t {
  kTerminal = 1,  // the body comes to rest after it, without a further event
  kEdge = 2,      // the next node is that of the next event, and this one's simulated edge leads there
  kDubious = 4,   // something on that edge, or before that rest, could be heard either way
};

// Columns, row i is node i. Nodes of one simulation follow one another in the order of time. Principal axes.
//
// An event begins with an impact, its onset. Then come its chain of hits and silent contact; with the last of
// these the body takes off, and flies to the next event. A discrete impact that nothing follows but flight is
// onset and take-off in one. Where the next event begins while the body touches the ground no flight leads
// there (flight_s is 0): such an edge can be used as simulated, but not be spliced.
template <template <class> class Column>
struct NodeTable {
  Column<double> onset;    // (n, 11) just after the onset: height, quaternion wxyz, velocity, spin; world
  Column<float> take_off;  // (n, 10) just after take-off: up, velocity, spin in principal axes; height
  Column<float> change;    // (n, 6) of velocity and spin, from before the onset to after take-off; likewise
  Column<float>
      delay_s;  // (n) from the onset to take-off; where no flight follows to the next onset, or to rest
  Column<float> flight_s;  // (n) from take-off to the next onset; 0 where none leads there
  // (n) total energy just before the last contact, its impact or step; for the connection must not exceed it
  Column<float> energy_j;
  Column<float> amplitude;  // (n) of the event, N s; not normalised
  Column<float> length_s;   // (n) 0: discrete
  Column<float> centroid_s;
  Column<std::uint32_t> simulation;  // (n)
  Column<std::uint8_t> flags;        // (n) NodeFlag

  // f(column, numbers in a row, name), for each.
  template <class Self, class F>
  static void each(Self& self, F&& f) {
    f(self.onset, 11, "onset");
    f(self.take_off, 10, "take_off");
    f(self.change, 6, "change");
    f(self.delay_s, 1, "delay_s");
    f(self.flight_s, 1, "flight_s");
    f(self.energy_j, 1, "energy_j");
    f(self.amplitude, 1, "amplitude");
    f(self.length_s, 1, "length_s");
    f(self.centroid_s, 1, "centroid_s");
    f(self.simulation, 1, "simulation");
    f(self.flags, 1, "flags");
  }

  std::size_t size() const { return flags.size(); }
};

template <class T>
using View = std::span<const T>;
template <class T>
using Owned = std::vector<T>;

using NodeColumns = NodeTable<Owned>;  // while they are made
using Nodes = NodeTable<View>;         // mapped from a file, or of a NodeColumns

Nodes view_of(const NodeColumns& columns);
void append(NodeColumns& to, const NodeColumns& from);

State onset_of(const Nodes& nodes, std::size_t i);  // just after it, at x = y = 0

// Features of a take-off that do not change with where on the plane, and in which heading, it happens.
struct TakeOffView {
  Vec3 up, velocity, spin;  // principal axes
  double height_m;
};
TakeOffView take_off_of(const Nodes& nodes, std::size_t i);
TakeOffView take_off_of(const State& state);

}  // namespace ifa
