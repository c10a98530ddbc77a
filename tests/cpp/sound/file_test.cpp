#include "ifa/sound/file.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <limits>
#include <string>

#include "ifa/base/error.hpp"
#include "ifa/base/random.hpp"

namespace ifa {
namespace {

namespace fs = std::filesystem;

class SoundFile : public testing::Test {
 protected:
  void SetUp() override {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::path(testing::TempDir()) / (std::string("ifa_sound_") + test->name());
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path write_bytes(const std::string& name, const std::string& bytes) const {
    std::ofstream(folder_ / name, std::ios::binary) << bytes;
    return folder_ / name;
  }

  fs::path folder_;
};

std::string little_endian(std::uint32_t value, int bytes) {
  std::string out;
  for (int i = 0; i < bytes; ++i) out.push_back(static_cast<char>(value >> (8 * i)));
  return out;
}

// A WAV file written by hand, after the RIFF definition: the oracle for reading. format 1 is PCM, 3 float.
std::string wav(int format, int channels, std::uint32_t rate_hz, int bits, const std::string& data,
                std::uint32_t claimed_bytes = 0) {
  const auto bytes = claimed_bytes ? claimed_bytes : static_cast<std::uint32_t>(data.size());
  const int frame = channels * bits / 8;
  return "RIFF" + little_endian(36 + bytes, 4) + "WAVEfmt " + little_endian(16, 4) +
         little_endian(format, 2) + little_endian(channels, 2) + little_endian(rate_hz, 4) +
         little_endian(rate_hz * frame, 4) + little_endian(frame, 2) + little_endian(bits, 2) + "data" +
         little_endian(bytes, 4) + data;
}

std::string floats(const std::vector<float>& values) {
  std::string data;
  for (const float x : values) data += little_endian(std::bit_cast<std::uint32_t>(x), 4);
  return data;
}

std::string complaint(const fs::path& path) {
  try {
    read_sound(path);
  } catch (const FileError& error) {
    return error.what();
  }
  return "";
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST_F(SoundFile, ReadsEveryCommonWidthAndRate) {
  for (const std::uint32_t rate : {8000u, 44100u, 48000u, 96000u}) {
    const Sound eight = read_sound(write_bytes("a.wav", wav(1, 1, rate, 8, std::string("\x80\xC0\x00", 3))));
    EXPECT_EQ(eight.samples, (std::vector<float>{0.0f, 0.5f, -1.0f}));
    EXPECT_EQ(eight.sample_rate_hz, static_cast<int>(rate));
    const std::string sixteen = little_endian(0, 2) + little_endian(0x4000, 2) + little_endian(0x8000, 2);
    EXPECT_EQ(read_sound(write_bytes("b.wav", wav(1, 1, rate, 16, sixteen))).samples,
              (std::vector<float>{0.0f, 0.5f, -1.0f}));
    const std::string wide = little_endian(1, 3) + little_endian(0x400000, 3) + little_endian(0x800000, 3);
    EXPECT_EQ(read_sound(write_bytes("c.wav", wav(1, 1, rate, 24, wide))).samples,
              (std::vector<float>{0x1p-23f, 0.5f, -1.0f}));
    EXPECT_EQ(read_sound(write_bytes("d.wav", wav(3, 1, rate, 32, floats({0.1f, -2.5f, 0.0f})))).samples,
              (std::vector<float>{0.1f, -2.5f, 0.0f}));  // float files may exceed full scale
  }
}

TEST_F(SoundFile, AveragesChannels) {
  const fs::path path =
      write_bytes("a.wav", wav(3, 2, 48000, 32, floats({1.0f, 0.5f, -1.0f, 1.0f, 0.0f, 0.25f})));
  EXPECT_EQ(read_sound(path).samples, (std::vector<float>{0.75f, 0.0f, 0.125f}));
}

TEST_F(SoundFile, ReadsPastOneBlockOfEveryChannelCount) {
  for (const int channels : {1, 2, 3, 7}) {
    std::vector<float> values;
    const int frames = 70000;  // more than one block for each count
    for (int i = 0; i < frames; ++i)
      for (int c = 0; c < channels; ++c) values.push_back(static_cast<float>(i % 1024) / 1024.0f);
    const Sound sound = read_sound(write_bytes("a.wav", wav(3, channels, 48000, 32, floats(values))));
    ASSERT_EQ(sound.samples.size(), static_cast<std::size_t>(frames));
    for (int i = 0; i < frames; ++i) ASSERT_EQ(sound.samples[i], static_cast<float>(i % 1024) / 1024.0f);
  }
}

TEST_F(SoundFile, WhatIsWrittenIsReadBackWithinOneStep) {
  RandomStream random(5, 0);
  Sound sound;
  sound.sample_rate_hz = 44100;
  for (int i = 0; i < 10000; ++i) sound.samples.push_back(static_cast<float>(random.uniform(-1.0, 1.0)));
  sound.samples.insert(sound.samples.end(), {1.0f, -1.0f, 0.0f});
  for (const int bits : {16, 24}) {
    const fs::path path = folder_ / "out.wav";
    write_wav(path, sound, bits);
    const Sound back = read_sound(path);
    ASSERT_EQ(back.samples.size(), sound.samples.size());
    EXPECT_EQ(back.sample_rate_hz, 44100);
    // rounding is half a step; full scale is one step less than 1 in two's complement
    const double tolerance = 1.51 * std::pow(2.0, 1 - bits);
    for (std::size_t i = 0; i < sound.samples.size(); ++i)
      ASSERT_NEAR(back.samples[i], sound.samples[i], tolerance)
          << "sample " << i << " at " << bits << " bits";
    EXPECT_EQ(fs::file_size(path),
              44 + sound.samples.size() * bits / 8 + (bits == 24) * (sound.samples.size() % 2));
  }
}

TEST_F(SoundFile, WritingLeavesNothingElseBehind) {
  const Sound sound{{0.5f}, 48000};
  write_wav(folder_ / "out.wav", sound);
  fs::create_directories(folder_ / "folder.wav" / "full");
  EXPECT_THROW(write_wav(folder_ / "folder.wav", sound), FileError);
  EXPECT_THROW(write_wav(folder_ / "missing" / "out.wav", sound), FileError);
  EXPECT_THROW(write_wav(folder_ / "out.wav", {{2.0f}, 48000}), ArgumentError);
  EXPECT_EQ(read_sound(folder_ / "out.wav").samples, std::vector<float>{0.5f});
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()), 2);
}

TEST_F(SoundFile, WhatCannotBeWritten) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const fs::path path = folder_ / "out.wav";
  EXPECT_THROW(write_wav(path, {{0.5f, 1.01f}, 48000}), ArgumentError);
  EXPECT_THROW(write_wav(path, {{nan}, 48000}), ArgumentError);
  EXPECT_THROW(write_wav(path, {{}, 48000}), ArgumentError);
  EXPECT_THROW(write_wav(path, {{0.5f}, 0}), ArgumentError);
  EXPECT_THROW(write_wav(path, {{0.5f}, -48000}), ArgumentError);
  EXPECT_THROW(write_wav(path, {{0.5f}, 48000}, 12), ArgumentError);
  EXPECT_FALSE(fs::exists(path));
}

TEST_F(SoundFile, EveryBadFileIsNamed) {
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  const std::string good = floats({0.5f, 0.25f});
  const struct {
    fs::path path;
    const char* reason;
  } cases[] = {
      {folder_ / "missing.wav", "no such file"},
      {folder_, "is a folder"},
      {"/dev/null", "not a regular file"},
      {write_bytes("empty.wav", ""), "is empty"},
      {write_bytes("text.wav", "0.1\t0.1\tlabel\n"), "is no sound"},
      {write_bytes("cut.wav", wav(1, 1, 48000, 16, "").substr(0, 20)), "is no sound"},
      {write_bytes("none.wav", wav(1, 1, 48000, 16, "")), "no samples"},
      {write_bytes("nan.wav", wav(3, 1, 48000, 32, floats({0.5f, nan}))), "sample 2 is not a finite number"},
      {write_bytes("inf.wav", wav(3, 2, 48000, 32, floats({0.5f, 0.5f, inf, -inf}))), "sample 2 is not"},
      {write_bytes("slow.wav", wav(3, 1, 12, 32, good)), "sample rate"},
      {write_bytes("fast.wav", wav(3, 1, 2'000'000, 32, good)), "sample rate"},
  };
  for (const auto& [path, reason] : cases) {
    EXPECT_PRED2(contains, complaint(path), reason);
    EXPECT_PRED2(contains, complaint(path), path.string());
  }
}

// The header claims 2 GB, the file holds two samples: memory follows the file.
TEST_F(SoundFile, TheHeadersLengthIsNotBelieved) {
  const fs::path path = write_bytes("a.wav", wav(3, 1, 48000, 32, floats({0.5f, 0.25f}), 0x7fffff00u));
  EXPECT_EQ(read_sound(path).samples, (std::vector<float>{0.5f, 0.25f}));
}

// Any bytes give a sound or a FileError: random ones, and a good file with some bytes changed or cut off.
TEST_F(SoundFile, DamagedFilesNeverDoAnythingElse) {
  RandomStream random(7, 0);
  const std::string good = wav(1, 2, 48000, 16, std::string(400, 'x'));
  int sounds = 0, errors = 0;
  for (int round = 0; round < 400; ++round) {
    std::string bytes = good;
    if (round % 4 == 0) {
      for (char& c : bytes) c = static_cast<char>(random.uniform(0.0, 256.0));
    } else {
      for (int i = 0; i < 3; ++i)
        bytes[static_cast<std::size_t>(random.uniform(0.0, 44.0))] = char(random.uniform(0.0, 256.0));
      if (round % 4 == 1) bytes.resize(static_cast<std::size_t>(random.uniform(1.0, 440.0)));
    }
    const fs::path path = write_bytes("a.wav", bytes);
    try {
      const Sound sound = read_sound(path);
      EXPECT_FALSE(sound.samples.empty());
      ++sounds;
    } catch (const FileError&) {
      ++errors;
    }
  }
  EXPECT_GT(sounds, 0);
  EXPECT_GT(errors, 0);
}

}  // namespace
}  // namespace ifa
