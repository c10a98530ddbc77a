#include "ifa/rigid/flock.hpp"

#include <gtest/gtest.h>

#include "ifa/base/random.hpp"
#include "sample_bodies.hpp"

namespace ifa {
namespace {

struct Member : lanes::Sim {};

// Bounces for ever, and cancels itself after so many steps: calls count the work done since.
class Endless {
 public:
  static constexpr bool kStrikesAtStart = false, kWantsLoads = true;

  Endless(Flock<Member>& flock, Progress& progress, int cancels_at)
      : flock_(flock), progress_(progress), cancels_at_(cancels_at) {}

  bool begin(Member& m) {
    State s;
    s.position.z() = 0.02 + 0.01 * random_.uniform();
    s.velocity.x() = 0.5;
    static_cast<lanes::Sim&>(m) = begin_sim(flock_.body(), flock_.settings(), s, 0.0);
    m.until_s = 1e9;
    return true;
  }

  void impact(Member&) { count(); }
  bool resolved(Member&, const lanes::HitData&) { return true; }
  bool loaded(Member&, const lanes::LoadData&) {
    count();
    return true;
  }
  void ended(Member&, lanes::Stop) { count(); }

  int after_cancel() const { return after_; }

 private:
  void count() {
    if (progress_.cancelled()) ++after_;
    if (++steps_ == cancels_at_) progress_.cancel();
  }

  Flock<Member>& flock_;
  Progress& progress_;
  int cancels_at_, steps_ = 0, after_ = 0;
  RandomStream random_{61, 0};
};

// A cancel is seen before the next pack: at most the pack that is under way is finished, which is one flight,
// impact or step for each of its lanes, whatever the number of simulations.
TEST(Flock, CancelIsSeenBeforeTheNextPack) {
  for (const lanes::Kernels* kernels : lanes::available_kernels()) {
    for (const double restitution : {1.0, 0.3}) {  // impacts for ever; or mostly steps of contact
      const Body body = sample::ball(0.02, 0.03, sample::ideal(restitution, 0.0));
      for (const int cancels_at : {1, 50, 1234}) {
        Flock<Member> flock(body, {}, *kernels);
        Progress progress;
        Endless client(flock, progress, cancels_at);
        EXPECT_THROW(flock.run(client, &progress), Cancelled);
        EXPECT_LT(client.after_cancel(), kernels->width) << kernels->name;
      }
    }
  }
}

}  // namespace
}  // namespace ifa
