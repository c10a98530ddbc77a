// Named arrays in a folder, mapped into memory, with a manifest that says what they are.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "ifa/base/progress.hpp"
#include "ifa/graph/checksum.hpp"
#include "ifa/graph/files.hpp"

namespace ifa {

// What a manifest says beside the arrays: names of letters, digits and _, values of one line each, in order.
using Fields = std::vector<std::pair<std::string, std::string>>;

// Numbers as they are in memory, little-endian, row after row without a header, in the file `file`.
struct ArrayInfo {
  std::string name, type;  // u8, u16, u32, u64, f32, f64
  std::uint64_t width, rows, checksum;
  std::string file;

  std::uint64_t bytes() const { return rows * width * std::stoul(type.substr(1)) / 8; }
};

template <class T>
constexpr const char* number_type() {
  static_assert(std::is_unsigned_v<T> || std::is_floating_point_v<T>);
  if (std::is_floating_point_v<T>) return sizeof(T) == 4 ? "f32" : "f64";
  return sizeof(T) == 1 ? "u8" : sizeof(T) == 2 ? "u16" : sizeof(T) == 4 ? "u32" : "u64";
}

// A set of arrays: `SET.manifest` and the files it lists. Copies share the mappings.
class ArraySet {
 public:
  // Checks the manifest's own checksum and the sizes of the files: at once, however large they are. Throws
  // FileError where the set is not there, not whole or of another format.
  static ArraySet open(const std::filesystem::path& folder, const std::string& set);
  static bool exists(const std::filesystem::path& folder, const std::string& set);

  const Fields& fields() const { return fields_; }
  const std::string& field(const std::string& name) const;  // FileError where there is none
  const std::vector<ArrayInfo>& arrays() const { return arrays_; }

  // `rows` * `width` numbers. FileError where there is no such array, or of another type or width.
  template <class T>
  std::span<const T> array(const std::string& name, std::size_t width) const {
    const auto bytes = find(name, number_type<T>(), width);
    return {reinterpret_cast<const T*>(bytes.data()), bytes.size() / sizeof(T)};
  }

  // Reads everything and compares it with its checksums; FileError names the file that is damaged.
  void check(int threads, Progress* progress = nullptr) const;

 private:
  std::span<const std::byte> find(const std::string& name, const std::string& type, std::size_t width) const;

  std::filesystem::path folder_, manifest_;
  Fields fields_;
  std::vector<ArrayInfo> arrays_;
  std::vector<std::shared_ptr<const MappedFile>> maps_;
};

// Writes a set. Until it is committed, a set of that name which is there stays as it is, also if the process
// or the machine stops; files have their checksum in their name, so none is ever replaced by another.
class NewArraySet {
 public:
  // The lock must outlive it.
  NewArraySet(const FolderLock& lock, std::string set) : folder_(lock.folder()), set_(std::move(set)) {}

  // Whole rows of `width` numbers, added to the array `name`.
  template <class T>
  void append(const std::string& name, std::size_t width, std::span<const T> numbers) {
    add(name, number_type<T>(), width, numbers.size() / width, std::as_bytes(numbers));
  }

  // Removes what an earlier set of this name, or an attempt that was cut short, has left.
  void commit(const Fields& fields);

 private:
  struct Column {
    ArrayInfo info;
    NewFile file;
    Checksum sum;
  };

  void add(const std::string& name, const std::string& type, std::size_t width, std::size_t rows,
           std::span<const std::byte> bytes);

  std::filesystem::path folder_;
  std::string set_;
  std::vector<std::string> order_;
  std::map<std::string, Column> columns_;
};

// A manifest's text: a first line that says what it is, the fields, the arrays, and a checksum of all that.
std::string to_text(const Fields& fields, const std::vector<ArrayInfo>& arrays);
// `path` is for messages.
std::pair<Fields, std::vector<ArrayInfo>> from_text(const std::string& text,
                                                    const std::filesystem::path& path);

}  // namespace ifa
