// Sound files, through libsndfile (the only file that includes sndfile.h is file.cpp).
#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

namespace ifa {

// One channel; full scale is -1 to 1, which float files may exceed.
struct Sound {
  std::vector<float> samples;
  int sample_rate_hz = 0;

  double duration_s() const { return static_cast<double>(samples.size()) / sample_rate_hz; }
};

// 93 minutes at 48 kHz, 1 GiB. A longer file is no contact sound, and more likely a damaged header.
inline constexpr std::size_t kMostSamples = std::size_t{1} << 28;

// Reads any format that libsndfile knows; channels are averaged. Throws FileError naming the file if it is
// missing, not a regular file, no sound, damaged, empty, longer than kMostSamples, of a sample rate outside
// 1 kHz to 1 MHz, or has a sample that is not finite.
Sound read_sound(const std::filesystem::path& path);

// Writes 16- or 24-bit PCM. The file appears whole or not at all: it is written beside `path` and renamed.
// Throws ArgumentError on another width, a rate outside 1 kHz to 1 MHz, no samples, more than kMostSamples or
// a sample outside -1 to 1 (nothing is clipped silently); FileError naming the file if it cannot be written.
void write_wav(const std::filesystem::path& path, const Sound& sound, int bits = 16);

}  // namespace ifa
