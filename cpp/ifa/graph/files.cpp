#include "ifa/graph/files.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <utility>

#include "ifa/base/error.hpp"

namespace ifa {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path& path, const char* what, int error = errno) {
  throw FileError(path.string() + ": " + what + ": " + std::generic_category().message(error));
}

}  // namespace

NewFile::NewFile(fs::path path) : temporary_(std::move(path)) {
  temporary_ += kEnding;
  file_ = ::open(temporary_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (file_ < 0) fail(temporary_, "cannot be written");
}

NewFile::NewFile(NewFile&& other) noexcept
    : temporary_(std::move(other.temporary_)), file_(std::exchange(other.file_, -1)) {}

NewFile::~NewFile() {
  if (file_ < 0) return;
  ::close(file_);
  ::unlink(temporary_.c_str());
}

void NewFile::write(std::span<const std::byte> bytes) {
  constexpr std::size_t kMost = std::size_t{1} << 30;  // Linux writes at most 2 GB at once
  while (!bytes.empty()) {
    const auto written = ::write(file_, bytes.data(), std::min(bytes.size(), kMost));
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail(temporary_, "cannot be written");
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
}

void NewFile::keep_as(const fs::path& path) {
  if (::fsync(file_) != 0) fail(temporary_, "cannot be written");
  if (::rename(temporary_.c_str(), path.c_str()) != 0) fail(path, "cannot be written");
  ::close(std::exchange(file_, -1));
}

void sync_folder(const fs::path& folder) {
  const int file = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (file < 0) fail(folder, "cannot be opened");
  const int failed = ::fsync(file);
  const int error = errno;
  ::close(file);
  if (failed && error != EINVAL) fail(folder, "cannot be written", error);  // EINVAL: needs no syncing
}

void write_whole(const fs::path& path, const std::string& text) {
  NewFile file(path);
  file.write(std::as_bytes(std::span(text)));
  file.keep_as(path);
  sync_folder(path.parent_path());
}

std::string read_text(const fs::path& path) {
  const MappedFile file(path);
  const auto bytes = file.bytes();
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

void remove_file(const fs::path& path) {
  if (::unlink(path.c_str()) != 0 && errno != ENOENT) fail(path, "cannot be removed");
}

MappedFile::MappedFile(const fs::path& path) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);  // a pipe shall not block
  if (file < 0) fail(path, "cannot be read");
  struct stat status;
  const bool known = ::fstat(file, &status) == 0;
  const int error = errno;
  if (!known || !S_ISREG(status.st_mode)) {
    ::close(file);
    if (!known) fail(path, "cannot be read", error);
    throw FileError(path.string() + ": is not a regular file");
  }
  size_ = static_cast<std::size_t>(status.st_size);
  void* mapped = size_ > 0 ? ::mmap(nullptr, size_, PROT_READ, MAP_SHARED, file, 0) : nullptr;
  const int map_error = errno;
  ::close(file);
  if (mapped == MAP_FAILED) fail(path, "cannot be mapped into memory", map_error);
  data_ = static_cast<const std::byte*>(mapped);
}

MappedFile::~MappedFile() {
  if (data_) ::munmap(const_cast<std::byte*>(data_), size_);
}

FolderLock::FolderLock(fs::path folder) : folder_(std::move(folder)) {
  file_ = ::open(folder_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (file_ < 0) fail(folder_, "cannot be opened");
  if (::flock(file_, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) return;
  ::close(file_);
  throw FileError(folder_.string() + ": is being written to by another process");
}

FolderLock::~FolderLock() { ::close(file_); }

}  // namespace ifa
