#include "ifa/sound/file.hpp"

#include <sndfile.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <memory>
#include <new>
#include <string>
#include <system_error>

#include "ifa/base/error.hpp"
#include "ifa/base/message.hpp"

namespace ifa {
namespace {

namespace fs = std::filesystem;

constexpr int kLowestRate_hz = 1000, kHighestRate_hz = 1'000'000;
constexpr sf_count_t kBlockSamples = 1 << 16;  // read at a time, over all channels

bool rate_is_sound(int rate_hz) { return rate_hz >= kLowestRate_hz && rate_hz <= kHighestRate_hz; }

struct Close {
  void operator()(SNDFILE* file) const { sf_close(file); }
};
using Handle = std::unique_ptr<SNDFILE, Close>;

// Looked at before opening: a directory or a pipe gives libsndfile a confusing error, or blocks it.
void check_regular_file(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (status.type() == fs::file_type::not_found) throw FileError(path.string() + ": there is no such file");
  if (status.type() == fs::file_type::directory)
    throw FileError(path.string() + ": is a folder, not a sound file");
  if (status.type() == fs::file_type::none)
    throw FileError(path.string() + ": cannot be looked at: " + error.message());
  if (status.type() != fs::file_type::regular) throw FileError(path.string() + ": is not a regular file");
  if (fs::file_size(path, error) == 0 && !error) throw FileError(path.string() + ": is empty");
}

// A new name in the folder of `path`, for this process and any that writes the same file at the same time.
fs::path temporary_beside(const fs::path& path) {
  static std::atomic<unsigned> counter{0};
  const auto now = std::chrono::steady_clock::now().time_since_epoch().count();
  fs::path name = path;
  name += ".part-" + std::to_string(now) + "-" + std::to_string(counter++);
  return name;
}

// Removes the temporary file unless it was renamed.
class Temporary {
 public:
  explicit Temporary(fs::path path) : path_(std::move(path)) {}
  Temporary(const Temporary&) = delete;
  Temporary& operator=(const Temporary&) = delete;
  ~Temporary() {
    std::error_code ignored;
    if (!renamed_) fs::remove(path_, ignored);
  }
  const fs::path& path() const { return path_; }
  void rename_to(const fs::path& target) {
    std::error_code error;
    fs::rename(path_, target, error);
    if (error) throw FileError(target.string() + ": cannot be written: " + error.message());
    renamed_ = true;
  }

 private:
  fs::path path_;
  bool renamed_ = false;
};

std::vector<float> read_mono(SNDFILE* file, const SF_INFO& info, const std::string& name) {
  const sf_count_t block_frames = std::max<sf_count_t>(1, kBlockSamples / info.channels);
  std::vector<float> block(static_cast<std::size_t>(block_frames) * info.channels);
  std::vector<float> mono;  // grows with what is read: the header's length is not believed
  for (;;) {
    const sf_count_t frames = sf_readf_float(file, block.data(), block_frames);
    if (frames <= 0) break;
    if (mono.size() + static_cast<std::size_t>(frames) > kMostSamples)
      throw FileError(name + ": is longer than " + std::to_string(kMostSamples) +
                      " samples, too long for a contact sound");
    for (sf_count_t i = 0; i < frames; ++i) {
      double sum = 0.0;
      for (int c = 0; c < info.channels; ++c) sum += block[static_cast<std::size_t>(i * info.channels + c)];
      if (!std::isfinite(sum))
        throw FileError(name + ": sample " + std::to_string(mono.size() + 1) + " is not a finite number");
      mono.push_back(static_cast<float>(sum / info.channels));
    }
  }
  if (sf_error(file)) throw FileError(name + ": is damaged: " + sf_strerror(file));
  if (mono.empty()) throw FileError(name + ": holds no samples");
  return mono;
}

}  // namespace

Sound read_sound(const fs::path& path) {
  check_regular_file(path);
  const std::string name = path.string();
  SF_INFO info{};
  const Handle file(sf_open(name.c_str(), SFM_READ, &info));
  if (!file) throw FileError(name + ": is no sound that can be read: " + sf_strerror(nullptr));
  if (info.channels < 1) throw FileError(name + ": is no sound that can be read: it has no channel");
  if (!rate_is_sound(info.samplerate))
    throw FileError(name + ": its sample rate of " + std::to_string(info.samplerate) +
                    " Hz is outside 1 kHz to 1 MHz");
  try {
    return {read_mono(file.get(), info, name), info.samplerate};
  } catch (const std::bad_alloc&) {
    throw FileError(name + ": does not fit into memory");
  }
}

void write_wav(const fs::path& path, const Sound& sound, int bits) {
  if (bits != 16 && bits != 24) throw ArgumentError("bits: must be 16 or 24, got " + std::to_string(bits));
  if (!rate_is_sound(sound.sample_rate_hz))
    throw ArgumentError("sample_rate_hz: must be between 1 kHz and 1 MHz, got " +
                        std::to_string(sound.sample_rate_hz) + " Hz");
  if (sound.samples.empty()) throw ArgumentError("samples: there are none");
  if (sound.samples.size() > kMostSamples)
    throw ArgumentError("samples: " + std::to_string(sound.samples.size()) + " are more than the " +
                        std::to_string(kMostSamples) + " that can be written");
  for (std::size_t i = 0; i < sound.samples.size(); ++i)
    if (!(std::abs(sound.samples[i]) <= 1.0f))
      throw ArgumentError("samples: sample " + std::to_string(i + 1) + " is " + number(sound.samples[i]) +
                          ", outside -1 to 1");

  Temporary temporary(temporary_beside(path));
  SF_INFO info{};
  info.channels = 1;
  info.samplerate = sound.sample_rate_hz;
  info.format = SF_FORMAT_WAV | (bits == 16 ? SF_FORMAT_PCM_16 : SF_FORMAT_PCM_24);
  Handle file(sf_open(temporary.path().string().c_str(), SFM_WRITE, &info));
  if (!file) throw FileError(path.string() + ": cannot be written: " + sf_strerror(nullptr));
  const auto wanted = static_cast<sf_count_t>(sound.samples.size());
  const bool whole = sf_writef_float(file.get(), sound.samples.data(), wanted) == wanted;
  if (sf_close(file.release()) != 0 || !whole)
    throw FileError(path.string() + ": could not be written to its end");
  temporary.rename_to(path);
}

}  // namespace ifa
