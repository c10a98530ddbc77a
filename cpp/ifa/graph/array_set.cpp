#include "ifa/graph/array_set.hpp"

#include <algorithm>
#include <atomic>
#include <charconv>
#include <cstdio>
#include <sstream>

#include "ifa/base/error.hpp"
#include "ifa/base/parallel.hpp"

namespace ifa {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFormat = "ifa arrays ";
constexpr int kVersion = 1;
constexpr const char* kArray = "array";  // not a field's name
constexpr const char* kSum = "checksum";

std::string hex(std::uint64_t value) {
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(value));
  return text;
}

bool parse(const std::string& text, std::uint64_t& value, int base) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, base);
  return error == std::errc() && end == text.data() + text.size();
}

std::uint64_t sum_of(std::string_view text) { return checksum(std::as_bytes(std::span(text))); }

bool is_name(std::string_view text) {
  return !text.empty() && text.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_") == text.npos;
}

// Of the line after its first word. Sizes that cannot be are refused, so that products do not overflow.
ArrayInfo array_of(const std::string& rest, const fs::path& path) {
  std::istringstream words(rest);
  ArrayInfo a;
  std::string width, rows, sum, more;
  words >> a.name >> a.type >> width >> rows >> sum >> a.file;
  constexpr std::string_view kTypes[] = {"u8", "u16", "u32", "u64", "f32", "f64"};
  constexpr std::uint64_t kMostWidth = 1u << 16, kMostRows = std::uint64_t{1} << 40;
  const bool good = words && !(words >> more) && is_name(a.name) && std::ranges::count(kTypes, a.type) == 1 &&
                    parse(width, a.width, 10) && a.width >= 1 && a.width <= kMostWidth &&
                    parse(rows, a.rows, 10) && a.rows <= kMostRows && parse(sum, a.checksum, 16) &&
                    a.file.find('/') == a.file.npos;
  if (!good) throw FileError(path.string() + ": the line of an array cannot be read: " + rest);
  return a;
}

fs::path manifest_of(const fs::path& folder, const std::string& set) { return folder / (set + ".manifest"); }

}  // namespace

std::string to_text(const Fields& fields, const std::vector<ArrayInfo>& arrays) {
  std::string text = kFormat + std::to_string(kVersion) + "\n";
  for (const auto& [name, value] : fields) text += name + " " + value + "\n";
  for (const ArrayInfo& a : arrays)
    text += std::string(kArray) + " " + a.name + " " + a.type + " " + std::to_string(a.width) + " " +
            std::to_string(a.rows) + " " + hex(a.checksum) + " " + a.file + "\n";
  return text + kSum + " " + hex(sum_of(text)) + "\n";
}

std::pair<Fields, std::vector<ArrayInfo>> from_text(const std::string& text, const fs::path& path) {
  const std::string format = kFormat;
  if (!text.starts_with(format)) throw FileError(path.string() + ": is not a manifest of ifa");
  const std::string version = text.substr(format.size(), text.find('\n') - format.size());
  if (version != std::to_string(kVersion))
    throw FileError(path.string() + ": is of format " + version.substr(0, 20) +
                    ", this version of ifa reads format " + std::to_string(kVersion));
  const std::size_t last = text.find_last_of('\n', text.size() - 2) + 1;
  if (text.substr(last) != kSum + std::string(" ") + hex(sum_of(text.substr(0, last))) + "\n")
    throw FileError(path.string() + ": is damaged: it does not have its checksum");
  Fields fields;
  std::vector<ArrayInfo> arrays;
  std::istringstream lines(text.substr(0, last));
  std::string line;
  std::getline(lines, line);
  while (std::getline(lines, line)) {
    const std::size_t space = std::min(line.find(' '), line.size());
    const std::string name = line.substr(0, space);
    const std::string value = space < line.size() ? line.substr(space + 1) : "";
    if (name == kArray)
      arrays.push_back(array_of(value, path));
    else
      fields.emplace_back(name, value);
  }
  return {fields, arrays};
}

bool ArraySet::exists(const fs::path& folder, const std::string& set) {
  std::error_code error;
  return fs::exists(manifest_of(folder, set), error);
}

ArraySet ArraySet::open(const fs::path& folder, const std::string& set) {
  ArraySet s;
  s.folder_ = folder;
  s.manifest_ = manifest_of(folder, set);
  std::tie(s.fields_, s.arrays_) = from_text(read_text(s.manifest_), s.manifest_);
  for (const ArrayInfo& a : s.arrays_) {
    s.maps_.push_back(std::make_shared<MappedFile>(folder / a.file));
    const std::size_t size = s.maps_.back()->bytes().size();
    if (size != a.bytes())
      throw FileError((folder / a.file).string() + ": is damaged: it has " + std::to_string(size) +
                      " bytes, not " + std::to_string(a.bytes()));
  }
  return s;
}

const std::string& ArraySet::field(const std::string& name) const {
  const auto at = std::ranges::find(fields_, name, &Fields::value_type::first);
  if (at == fields_.end()) throw FileError(manifest_.string() + ": does not say " + name);
  return at->second;
}

std::span<const std::byte> ArraySet::find(const std::string& name, const std::string& type,
                                          std::size_t width) const {
  const auto at = std::ranges::find(arrays_, name, &ArrayInfo::name);
  if (at == arrays_.end()) throw FileError(manifest_.string() + ": has no array " + name);
  if (at->type != type || at->width != width)
    throw FileError(manifest_.string() + ": its array " + name + " has " + std::to_string(at->width) + " " +
                    at->type + " in a row, not " + std::to_string(width) + " " + type);
  return maps_[static_cast<std::size_t>(at - arrays_.begin())]->bytes();
}

void ArraySet::check(int threads, Progress* progress) const {
  constexpr std::size_t kPiece = 1 << 22;  // between looks at `progress`
  std::uint64_t whole = 1;
  for (const ArrayInfo& a : arrays_) whole += a.bytes();
  std::atomic<std::uint64_t> done = 0;
  const auto check_one = [&](std::size_t i) {
    Checksum sum;
    for (auto bytes = maps_[i]->bytes(); !bytes.empty();) {
      if (progress) progress->throw_if_cancelled();
      const auto piece = bytes.first(std::min(kPiece, bytes.size()));
      sum.add(piece);
      bytes = bytes.subspan(piece.size());
      done += piece.size();
      if (progress) progress->raise_to(static_cast<double>(done) / static_cast<double>(whole));
    }
    if (sum.value() != arrays_[i].checksum)
      throw FileError((folder_ / arrays_[i].file).string() + ": is damaged: it does not have its checksum");
  };
  parallel_for(arrays_.size(), threads, check_one, progress);
  if (progress) progress->raise_to(1.0);
}

void NewArraySet::add(const std::string& name, const std::string& type, std::size_t width, std::size_t rows,
                      std::span<const std::byte> bytes) {
  auto at = columns_.find(name);
  if (at == columns_.end()) {
    order_.push_back(name);
    Column column{{name, type, width, 0, 0, ""}, NewFile(folder_ / (set_ + "." + name)), {}};
    at = columns_.emplace(name, std::move(column)).first;
  }
  Column& column = at->second;
  column.file.write(bytes);
  column.sum.add(bytes);
  column.info.rows += rows;
}

void NewArraySet::commit(const Fields& fields) {
  std::vector<ArrayInfo> arrays;
  const fs::path manifest = manifest_of(folder_, set_);
  std::vector<fs::path> ours{manifest};
  for (const std::string& name : order_) {
    Column& column = columns_.at(name);
    ArrayInfo& info = column.info;
    info.checksum = column.sum.value();
    info.file = set_ + "." + name + "." + hex(info.checksum) + "." + info.type;
    ours.push_back(folder_ / info.file);
    column.file.keep_as(ours.back());
    arrays.push_back(info);
  }
  columns_.clear();
  sync_folder(folder_);
  write_whole(manifest, to_text(fields, arrays));
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder_, error))
    if (entry.path().filename().string().starts_with(set_ + ".") &&
        std::ranges::find(ours, entry.path()) == ours.end())
      remove_file(entry.path());
}

}  // namespace ifa
