// Files that are whole or not there, whenever the process or the machine stops. Every failure is a FileError
// that names the file.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>

namespace ifa {

// A file that is being written, under a temporary name in the folder where it shall be. It is removed unless
// kept.
class NewFile {
 public:
  static constexpr const char* kEnding = ".part";  // of the temporary name

  explicit NewFile(std::filesystem::path path);  // the temporary file: `path` and the ending
  NewFile(NewFile&& other) noexcept;
  NewFile& operator=(NewFile&&) = delete;
  ~NewFile();

  void write(std::span<const std::byte> bytes);

  // Brings it to the disk and gives it its name, replacing what had it. `sync_folder` makes the name last.
  void keep_as(const std::filesystem::path& path);

 private:
  std::filesystem::path temporary_;
  int file_ = -1;
};

void sync_folder(const std::filesystem::path& folder);

// Writes, keeps and makes it last.
void write_whole(const std::filesystem::path& path, const std::string& text);

std::string read_text(const std::filesystem::path& path);

void remove_file(const std::filesystem::path& path);  // if it is there

// Read-only memory mapping of a file. It must not be truncated meanwhile.
class MappedFile {
 public:
  explicit MappedFile(const std::filesystem::path& path);
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;
  ~MappedFile();

  std::span<const std::byte> bytes() const { return {data_, size_}; }

 private:
  const std::byte* data_ = nullptr;
  std::size_t size_ = 0;
};

// Who holds it may change what is in the folder; it ends with its holder or the process. Where the file
// system has no locks it locks nothing.
class FolderLock {
 public:
  // Throws FileError where another one holds it.
  explicit FolderLock(std::filesystem::path folder);
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;
  ~FolderLock();

  const std::filesystem::path& folder() const { return folder_; }

 private:
  std::filesystem::path folder_;
  int file_ = -1;
};

}  // namespace ifa
