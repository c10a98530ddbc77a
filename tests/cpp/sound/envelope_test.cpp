#include "ifa/sound/envelope.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "ifa/base/error.hpp"
#include "ifa/base/random.hpp"

namespace ifa {
namespace {

Sound silence(double length_s, int rate_hz = 48000) {
  return {std::vector<float>(static_cast<std::size_t>(std::lround(length_s * rate_hz))), rate_hz};
}

void put(Sound& sound, double time_s, float value) {
  sound.samples[static_cast<std::size_t>(std::lround(time_s * sound.sample_rate_hz))] = value;
}

std::string complaint(const Sound& sound, const std::vector<double>& times_s,
                      const std::vector<double>& durations_s) {
  try {
    mark_amplitudes(sound, times_s, durations_s);
  } catch (const ArgumentError& error) {
    return error.what();
  }
  return "";
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

class EveryRate : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Envelope, EveryRate, testing::Values(8000, 22050, 44100, 48000, 96000));

// A sample at the window's last instant counts, the next one does not. Values are powers of two or
// compared as floats, so equality is exact.
TEST_P(EveryRate, TheWindowIs20MillisecondsAfterTheMark) {
  const int rate = GetParam();
  const double time_s = 0.1, sample_s = 1.0 / rate;
  const auto window = static_cast<int>(std::lround(0.020 * rate));
  const auto start = static_cast<int>(std::lround(time_s * rate));
  for (const int offset : {-1, 0, 1, window - 1, window, window + 1}) {
    Sound sound = silence(0.5, rate);
    sound.samples[start] = 0.125f;
    sound.samples[start + offset] = -0.75f;  // the sign does not count
    const bool inside = offset >= 0 && offset < window;
    const double expected = inside ? 0.75 : 0.125;
    EXPECT_EQ(mark_amplitudes(sound, {start * sample_s}, {0.0}).amplitudes[0], expected) << offset;
  }
}

TEST(Envelope, ALoudSuccessorDoesNotCountForAQuietHit) {
  Sound sound = silence(1.0);
  put(sound, 0.500, 0.25f);  // the quiet hit
  put(sound, 0.506, 0.5f);   // before half of the 14 ms to the next mark: its own
  put(sound, 0.508, 0.75f);  // after half: neither hit's
  put(sound, 0.514, 1.0f);
  const MarkAmplitudes found = mark_amplitudes(sound, {0.500, 0.514}, {0.0, 0.0});
  EXPECT_EQ(found.amplitudes, (std::vector<double>{0.5, 1.0}));
  EXPECT_EQ(mark_amplitudes(sound, {0.500}, {0.0}).amplitudes, std::vector<double>{1.0});
}

// Against a direct reading of the definition: every sample is asked whether its time is in the window.
TEST(Envelope, AgreesWithTheDefinitionOnNoise) {
  RandomStream random(3, 0);
  Sound sound = silence(2.0, 8000);
  for (float& x : sound.samples) x = static_cast<float>(random.normal());
  for (int round = 0; round < 50; ++round) {
    std::vector<double> times_s{random.uniform(0.0, 0.1)}, durations_s{0.0};
    while (times_s.back() < 1.7) {
      times_s.push_back(times_s.back() + durations_s.back() + random.uniform(0.01, 0.08));
      durations_s.push_back(random.uniform() < 0.3 ? random.uniform(0.01, 0.1) : 0.0);
    }
    const MarkAmplitudes found = mark_amplitudes(sound, times_s, durations_s);
    for (std::size_t k = 0; k < times_s.size(); ++k) {
      double end_s = times_s[k] + durations_s[k];
      if (durations_s[k] == 0.0) {
        end_s += 0.020;
        if (k + 1 < times_s.size()) end_s = std::min(end_s, 0.5 * (times_s[k] + times_s[k + 1]));
      }
      double largest = 0.0;
      for (std::size_t i = 0; i < sound.samples.size(); ++i)
        if (i / 8000.0 >= times_s[k] && i / 8000.0 < end_s)
          largest = std::max(largest, std::abs(static_cast<double>(sound.samples[i])));
      ASSERT_EQ(found.amplitudes[k], largest) << "round " << round << ", mark " << k + 1;
      ASSERT_EQ(std::isnan(found.centroids_s[k]), durations_s[k] == 0.0);
    }
  }
}

// Steady noise-like loudness is balanced at the middle, a ramp at two thirds, a burst at itself. The
// envelope has bins of 1 ms, so half of one is the tolerance.
TEST_P(EveryRate, CentroidsOfKnownEnvelopes) {
  const int rate = GetParam();
  const double start_s = 0.2, span_s = 0.3;
  const auto centroid = [&](auto loudness) {
    Sound sound = silence(1.0, rate);
    for (std::size_t i = 0; i < sound.samples.size(); ++i)
      sound.samples[i] = static_cast<float>((i % 2 ? -1.0 : 1.0) * loudness(double(i) / rate - start_s));
    return mark_amplitudes(sound, {start_s}, {span_s}).centroids_s[0];
  };
  EXPECT_NEAR(centroid([](double) { return 0.5; }), span_s / 2, 5e-4);
  EXPECT_NEAR(centroid([&](double t) { return t > 0 ? t / span_s * 0.9 : 0.0; }), span_s * 2 / 3, 5e-4);
  EXPECT_NEAR(centroid([&](double t) { return t > 0 ? (1 - t / span_s) * 0.9 : 0.7; }), span_s / 3, 5e-4);
  EXPECT_NEAR(centroid([](double t) { return t > 0.25 && t < 0.254 ? 0.5 : 0.0; }), 0.252, 5e-4);
}

TEST(Envelope, AmplitudeOfASpanIsItsPeak) {
  Sound sound = silence(1.0);
  put(sound, 0.3, 0.25f);
  put(sound, 0.45, -0.5f);
  put(sound, 0.51, 1.0f);  // after the span
  EXPECT_EQ(mark_amplitudes(sound, {0.3}, {0.2}).amplitudes[0], 0.5);
}

TEST(Envelope, ASilentSpanHasNoCentroid) {
  Sound sound = silence(1.0);
  put(sound, 0.1, 0.5f);
  const MarkAmplitudes found = mark_amplitudes(sound, {0.1, 0.5}, {0.0, 0.2});
  EXPECT_EQ(found.amplitudes[1], 0.0);
  EXPECT_TRUE(std::isnan(found.centroids_s[1]));
}

TEST(Envelope, MarksAtBothEndsOfTheSound) {
  Sound sound = silence(0.5);
  sound.samples.front() = 0.25f;
  sound.samples.back() = 0.5f;
  const double last_s = (sound.samples.size() - 1) / 48000.0;
  EXPECT_EQ(mark_amplitudes(sound, {0.0, last_s}, {0.0, 0.0}).amplitudes, (std::vector<double>{0.25, 0.5}));
  // between the last sample and the end, less than a sample later: still inside
  EXPECT_EQ(mark_amplitudes(sound, {last_s + 1e-5}, {0.0}).amplitudes[0], 0.5);
}

TEST(Envelope, MarksCloserThanASampleStillHaveOne) {
  Sound sound = silence(0.5, 8000);
  for (float& x : sound.samples) x = 0.5f;
  const MarkAmplitudes found = mark_amplitudes(sound, {0.100001, 0.100002, 0.100003}, {0.0, 1e-6, 0.0});
  EXPECT_EQ(found.amplitudes, (std::vector<double>{0.5, 0.5, 0.5}));
  EXPECT_GE(found.centroids_s[1], 0.0);
  EXPECT_LE(found.centroids_s[1], 1e-6);
}

TEST(Envelope, MarksOutsideTheSoundAreNamed) {
  Sound sound = silence(0.5);
  put(sound, 0.1, 0.5f);
  EXPECT_PRED2(contains, complaint(sound, {0.1, 0.5}, {0.0, 0.0}), "mark 2 (0.50 s): lies outside the sound");
  EXPECT_PRED2(contains, complaint(sound, {-0.1}, {0.0}), "mark 1 (-0.10 s): lies outside");
  EXPECT_PRED2(contains, complaint(sound, {0.1, 1e300}, {0.0, 0.0}), "mark 2");
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_PRED2(contains, complaint(sound, {nan}, {0.0}), "mark 1");
  EXPECT_PRED2(contains, complaint(sound, {0.1}, {nan}), "mark 1");
  EXPECT_PRED2(contains, complaint(sound, {0.1}, {}), "durations_s");
}

TEST(Envelope, ASpanMayEndALittleAfterTheSound) {
  Sound sound = silence(0.5);
  for (float& x : sound.samples) x = 0.5f;
  const double start_s = 0.4;
  // the cut span is 0.1 s; the tolerance is half a bin
  EXPECT_NEAR(mark_amplitudes(sound, {start_s}, {0.119}).centroids_s[0], 0.05, 5e-4);
  EXPECT_PRED2(contains, complaint(sound, {start_s}, {0.121}), "mark 1 (0.40 s): its span ends at 0.521 s");
}

TEST(Envelope, SilenceAtTheFirstMarkIsAnError) {
  Sound sound = silence(0.5);
  put(sound, 0.2, 0.5f);
  EXPECT_PRED2(contains, complaint(sound, {0.1, 0.2}, {0.0, 0.0}), "mark 1 (0.10 s): the sound is silent");
  EXPECT_EQ(complaint(sound, {0.2, 0.3}, {0.0, 0.0}), "");
}

}  // namespace
}  // namespace ifa
