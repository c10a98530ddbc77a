// The nodes of a simulation against the simulation itself, event by event.
#include "ifa/graph/harvest.hpp"

#include <gtest/gtest.h>

#include "sample_bodies.hpp"

namespace ifa {
namespace {

TEST(Harvest, Report) {
  const Body die = sample::box(Vec3::Constant(0.016), 0.005);
  const SearchPhysics physics;
  const auto nodes = harvest(die, physics, {}, 1, 0, 2000, 30.0);
  std::size_t flights = 0, dubious = 0, terminal = 0, edges = 0, delayed = 0;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    flights += nodes.flight_s[i] > 0;
    delayed += nodes.flight_s[i] > 0 && nodes.delay_s[i] > 0;
    edges += (nodes.flags[i] & kEdge) != 0;
    terminal += (nodes.flags[i] & kTerminal) != 0;
    dubious += (nodes.flags[i] & kDubious) != 0;
  }
  printf("nodes %zu edges %zu flights %zu delayed %zu terminal %zu dubious %zu\n", nodes.size(), edges,
         flights, delayed, terminal, dubious);
}

}  // namespace
}  // namespace ifa
