// Batches against single simulations, bit for bit.
#include "ifa/rigid/batch.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <numeric>

#include "sample_bodies.hpp"

namespace ifa {
namespace {

constexpr std::size_t kRoom = 8;  // for hits: fewer than some samples have, more than others
constexpr double kOld = -7.5;     // what the arrays held before

// The caller's arrays.
struct Arrays {
  explicit Arrays(std::size_t n, std::size_t m = kRoom)
      : room(m), status(n, SampleStatus::failed), count(n, -1) {
    for (auto* a : {&end, &position, &quaternion, &velocity, &spin, &time, &impulse, &speed, &place}) {
      const bool of_hits = a == &time || a == &impulse || a == &speed || a == &place;
      const std::size_t width = a == &end || a == &time || a == &speed ? 1 : a == &quaternion ? 4 : 3;
      a->assign(n * width * (of_hits ? m : 1), kOld);
    }
  }

  BatchOutputs outputs() {
    return {status, end, position, quaternion, velocity, spin, count, time, impulse, speed, place, room};
  }

  bool operator==(const Arrays& o) const {
    const auto same = [](const std::vector<double>& a, const std::vector<double>& b) {
      return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0;
    };
    return status == o.status && count == o.count && same(end, o.end) && same(position, o.position) &&
           same(quaternion, o.quaternion) && same(velocity, o.velocity) && same(spin, o.spin) &&
           same(time, o.time) && same(impulse, o.impulse) && same(speed, o.speed) && same(place, o.place);
  }

  std::size_t room;
  std::vector<SampleStatus> status;
  std::vector<double> end, position, quaternion, velocity, spin, time, impulse, speed, place;
  std::vector<std::int32_t> count;
};

struct Scene {
  std::vector<Body> owned;
  std::vector<const Body*> bodies;
  std::vector<State> states;
};

// Four kinds of bodies in turn.
Scene mixed(std::size_t n) {
  Scene scene;
  scene.owned = {sample::box({0.01, 0.02, 0.03}, 0.05), sample::ball(0.02, 0.03),
                 sample::rod(0.1, 0.004, 0.02), sample::coin()};
  for (std::size_t i = 0; i < n; ++i) {
    RandomStream random(11, i);
    scene.bodies.push_back(&scene.owned[i % scene.owned.size()]);
    scene.states.push_back(sample::random_state(*scene.bodies.back(), random, 0.02, 1.0, 10.0));
  }
  return scene;
}

BatchOptions until(double until_s, int threads = 1) {
  BatchOptions options;
  options.until_s = until_s;
  options.threads = threads;
  return options;
}

Arrays run(const Scene& scene, const BatchOptions& options) {
  Arrays arrays(scene.states.size());
  simulate_batch(scene.bodies, scene.states, options, arrays.outputs());
  return arrays;
}

Vec3 row(const std::vector<double>& array, std::size_t i) {
  return Vec3(array[3 * i], array[3 * i + 1], array[3 * i + 2]);
}

TEST(Batch, SameBytesForAnyInstructionSet) {
  const Scene scene = mixed(120);
  BatchOptions options = until(30.0, 2);
  options.instruction_set = "scalar";
  const Arrays scalar = run(scene, options);
  for (const std::string_view name : instruction_sets()) {
    options.instruction_set = name;
    EXPECT_TRUE(run(scene, options) == scalar) << name;
  }
}

// Bodies whose impacts take every way out: needles whose moments differ by 1e9 to 1e12, jams, thin plates at
// 40 m/s. A lane that falls back must leave the others alone.
TEST(Batch, SameBytesForExtremeBodies) {
  RandomStream random(12, 0);
  for (const double ratio : {1.0, 1e-6, 1e-9, 1e-12})
    for (const double friction : {0.0, 1.2, 1.9}) {
      Body::Definition d = sample::box({0.1, 0.004, 0.002}, 0.01, {0.8, friction, 5e-5, 5e-5}).definition();
      d.inertia_kg_m2 = 1e-6 * Vec3(ratio, 1.0, 1.0).asDiagonal();
      const Body needle = Body::make(d);
      const Body plate = sample::box({0.1, 0.07, 1e-5}, 0.01, {0.8, friction, 5e-5, 5e-5});
      for (const Body* body : {&needle, &plate}) {
        Scene scene;
        for (int i = 0; i < 100; ++i) {
          scene.bodies.push_back(body);
          scene.states.push_back(sample::random_state(*body, random, 0.02, 2.0, 100.0));
          if (body == &plate) scene.states.back().velocity.z() = -40.0;
        }
        BatchOptions options = until(0.1);
        options.simulation.max_impacts = 100;
        options.instruction_set = "scalar";
        const Arrays scalar = run(scene, options);
        for (const std::string_view name : instruction_sets()) {
          options.instruction_set = name;
          EXPECT_TRUE(run(scene, options) == scalar) << name << " " << ratio << " " << friction;
        }
        for (const SampleStatus status : scalar.status) EXPECT_NE(status, SampleStatus::failed);
      }
    }
}

TEST(Batch, EachSampleIsASimulation) {
  const Scene scene = mixed(30);
  for (const double until_s : {0.1, 30.0}) {
    const Arrays got = run(scene, until(until_s, 2));
    for (std::size_t i = 0; i < scene.states.size(); ++i) {
      SCOPED_TRACE(i);
      const ifa::Run one = simulate(*scene.bodies[i], scene.states[i], {}, until_s);
      const Node& end = one.nodes.back();
      EXPECT_EQ(static_cast<int>(got.status[i]), static_cast<int>(one.status));
      EXPECT_EQ(got.end[i], one.status == RunStatus::rest ? one.rest_s : until_s);
      EXPECT_EQ(row(got.position, i), end.state.position);
      EXPECT_EQ(row(got.velocity, i), end.state.velocity);
      EXPECT_EQ(row(got.spin, i), end.state.angular_velocity);
      const double* q = &got.quaternion[4 * i];
      EXPECT_EQ(Quat(q[0], q[1], q[2], q[3]).coeffs(), end.state.orientation.coeffs());
      ASSERT_EQ(got.count[i], static_cast<int>(one.hits.size()));
      for (std::size_t k = 0; k < kRoom; ++k) {
        const std::size_t at = i * kRoom + k;
        if (k < one.hits.size()) {
          EXPECT_EQ(got.time[at], one.hits[k].time_s);
          EXPECT_EQ(row(got.impulse, at), one.hits[k].impulse_n_s);
          EXPECT_EQ(got.speed[at], one.hits[k].approach_speed_m_s);
          EXPECT_EQ(row(got.place, at), one.hits[k].position_m);
        } else {  // stays as it was
          EXPECT_EQ(got.time[at], kOld);
          EXPECT_EQ(row(got.impulse, at), Vec3::Constant(kOld));
          EXPECT_EQ(got.speed[at], kOld);
          EXPECT_EQ(row(got.place, at), Vec3::Constant(kOld));
        }
      }
    }
  }
  // Both kinds of samples that the comparison is about were there.
  const Arrays got = run(scene, until(0.1));
  EXPECT_LT(*std::min_element(got.count.begin(), got.count.end()), static_cast<int>(kRoom));
  const Arrays whole = run(scene, until(30.0));
  EXPECT_GT(*std::max_element(whole.count.begin(), whole.count.end()), static_cast<int>(kRoom));
}

TEST(Batch, SameBytesForAnyNumberOfThreads) {
  const Scene scene = mixed(40);
  const Arrays one = run(scene, until(1.0, 1));
  for (const int threads : {2, 3, 7, 64}) EXPECT_TRUE(run(scene, until(1.0, threads)) == one) << threads;
}

TEST(Batch, SameBytesInAnyOrderAndBatchSize) {
  const Scene scene = mixed(40);
  const Arrays whole = run(scene, until(1.0));
  std::vector<std::size_t> order(40);
  std::iota(order.begin(), order.end(), 0);
  std::rotate(order.begin(), order.begin() + 17, order.end());
  std::reverse(order.begin() + 5, order.end());
  for (const std::size_t size : {std::size_t{1}, std::size_t{7}, std::size_t{40}}) {
    for (std::size_t begin = 0; begin < order.size(); begin += size) {
      Scene part;
      for (std::size_t k = begin; k < std::min(begin + size, order.size()); ++k) {
        part.bodies.push_back(scene.bodies[order[k]]);
        part.states.push_back(scene.states[order[k]]);
      }
      const Arrays got = run(part, until(1.0, 2));
      for (std::size_t k = 0; k < part.states.size(); ++k) {
        const std::size_t i = order[begin + k];
        EXPECT_EQ(got.status[k], whole.status[i]);
        EXPECT_EQ(got.end[k], whole.end[i]);
        EXPECT_EQ(got.count[k], whole.count[i]);
        EXPECT_EQ(row(got.position, k), row(whole.position, i));
        EXPECT_EQ(row(got.spin, k), row(whole.spin, i));
        EXPECT_TRUE(std::equal(&got.time[k * kRoom], &got.time[k * kRoom] + kRoom, &whole.time[i * kRoom]));
      }
    }
  }
}

TEST(Batch, OneBodyServesAllStates) {
  Scene scene = mixed(12);
  std::fill(scene.bodies.begin(), scene.bodies.end(), &scene.owned[0]);
  for (std::size_t i = 0; i < 12; ++i) {
    RandomStream random(5, i);
    scene.states[i] = sample::random_state(scene.owned[0], random, 0.01, 1.0, 10.0);
  }
  const Arrays many = run(scene, until(1.0));
  scene.bodies.resize(1);
  EXPECT_TRUE(run(scene, until(1.0)) == many);
}

TEST(Batch, WritesOnlyWhatIsWanted) {
  const Scene scene = mixed(6);
  const Arrays all = run(scene, until(1.0));
  Arrays some(6);
  BatchOutputs outputs;
  outputs.end_time_s = some.end;
  simulate_batch(scene.bodies, scene.states, until(1.0), outputs);
  EXPECT_EQ(some.end, all.end);
  EXPECT_TRUE(std::all_of(some.position.begin(), some.position.end(), [](double x) { return x == kOld; }));
}

TEST(Batch, SaysWhyEachSampleEnded) {
  const Body bouncy = sample::ball(0.02, 0.03, sample::ideal(1.0, 0.0)), dull = sample::ball(0.02, 0.03);
  State s;
  s.position.z() = 0.03;
  Scene scene;
  scene.bodies = {&bouncy, &dull};
  scene.states = {s, s};
  BatchOptions options = until(1e9);
  options.simulation.max_impacts = 50;
  Arrays got = run(scene, options);
  EXPECT_EQ(got.status[0], SampleStatus::impact_limit);
  EXPECT_EQ(got.count[0], 50);
  EXPECT_EQ(got.status[1], SampleStatus::rest);
  got = run(scene, until(0.01));
  EXPECT_EQ(got.status[0], SampleStatus::time_limit);
  // free fall of 0.01 s
  EXPECT_NEAR(got.position[2], 0.03 - 0.5 * sample::kGravity * 1e-4, 1e-15);
}

TEST(Batch, AnEmptyBatchIsDone) {
  Arrays got(0);
  const Body body = sample::ball(0.02, 0.03);
  const std::vector<const Body*> one = {&body};
  EXPECT_NO_THROW(simulate_batch(one, {}, until(1.0), got.outputs()));
  EXPECT_TRUE(got.status.empty());
}

TEST(Batch, ACancelledBatchSaysWhatIsDone) {
  const Scene scene = mixed(5);
  Progress progress;
  progress.cancel();
  Arrays got(5);
  EXPECT_THROW(simulate_batch(scene.bodies, scene.states, until(1.0, 2), got.outputs(), &progress),
               Cancelled);
  for (std::size_t i = 0; i < 5; ++i) EXPECT_EQ(got.status[i], SampleStatus::not_run);
  EXPECT_EQ(got.end, std::vector<double>(5, kOld));
}

TEST(Batch, ProgressEndsAtOne) {
  const Scene scene = mixed(9);
  Progress progress;
  Arrays got(9);
  simulate_batch(scene.bodies, scene.states, until(0.1, 2), got.outputs(), &progress);
  EXPECT_EQ(progress.fraction(), 1.0);
}

}  // namespace
}  // namespace ifa
