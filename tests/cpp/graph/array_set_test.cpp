#include "ifa/graph/array_set.hpp"

#include <gtest/gtest.h>

#include <cstring>

#include "folders.hpp"
#include "ifa/base/error.hpp"

namespace ifa {
namespace {

using sample::content;
using sample::message_of;
using sample::put;

const std::vector<double> kPoints{0.5, -1.25, 1e300, 3.0, 4.0, -0.0};
const std::vector<std::uint16_t> kCounts{7, 65535};

void write(const std::filesystem::path& folder, const std::vector<std::uint16_t>& counts = kCounts) {
  const FolderLock lock(folder);
  NewArraySet set(lock, "things");
  set.append<double>("points", 3, std::span(kPoints).first(3));
  set.append<std::uint16_t>("counts", 1, counts);
  set.append<double>("points", 3, std::span(kPoints).last(3));
  set.append<float>("nothing", 4, {});
  set.commit({{"colour", "deep  red"}, {"empty", ""}});
}

std::filesystem::path file_of(const std::filesystem::path& folder, const std::string& name) {
  const ArraySet set = ArraySet::open(folder, "things");
  for (const ArrayInfo& a : set.arrays())
    if (a.name == name) return folder / a.file;
  ADD_FAILURE();
  return {};
}

TEST(ArraySet, ReadsWhatWasWritten) {
  const sample::TemporaryFolder folder;
  write(folder.path());
  const ArraySet set = ArraySet::open(folder.path(), "things");
  const auto points = set.array<double>("points", 3);
  EXPECT_EQ(std::vector<double>(points.begin(), points.end()), kPoints);
  const auto counts = set.array<std::uint16_t>("counts", 1);
  EXPECT_EQ(std::vector<std::uint16_t>(counts.begin(), counts.end()), kCounts);
  EXPECT_TRUE(set.array<float>("nothing", 4).empty());
  EXPECT_EQ(set.field("colour"), "deep  red");
  EXPECT_EQ(set.field("empty"), "");
  set.check(2);
  // A file is the numbers as they are in memory, for whoever reads it without us.
  EXPECT_EQ(content(file_of(folder.path(), "points")),
            std::string(reinterpret_cast<const char*>(kPoints.data()), 48));
}

TEST(ArraySet, ArraysAreWhatTheReaderTakesThemFor) {
  const sample::TemporaryFolder folder;
  write(folder.path());
  const ArraySet set = ArraySet::open(folder.path(), "things");
  EXPECT_THROW(set.array<float>("points", 3), FileError);
  EXPECT_THROW(set.array<double>("points", 2), FileError);
  EXPECT_THROW(set.array<double>("lines", 3), FileError);
  EXPECT_THROW(set.field("weight"), FileError);
}

TEST(ArraySet, AnUncommittedSetLeavesTheOldOne) {
  const sample::TemporaryFolder folder;
  write(folder.path());
  const auto before = sample::contents(folder.path());
  {
    const FolderLock lock(folder.path());
    NewArraySet set(lock, "things");
    set.append<double>("points", 3, kPoints);
  }
  EXPECT_EQ(sample::contents(folder.path()), before);
}

// What was mapped before stays readable, and nothing of the old set is left.
TEST(ArraySet, ACommittedSetReplacesTheOldOne) {
  const sample::TemporaryFolder folder;
  write(folder.path());
  const ArraySet old = ArraySet::open(folder.path(), "things");
  put(folder.path() / "things.points.part", "left by a process that was killed");
  put(folder.path() / "other.txt", "not ours");
  write(folder.path(), {1, 2, 3});
  EXPECT_EQ(old.array<std::uint16_t>("counts", 1)[1], 65535);
  EXPECT_EQ(ArraySet::open(folder.path(), "things").array<std::uint16_t>("counts", 1).size(), 3u);
  EXPECT_EQ(sample::contents(folder.path()).size(), 5u);  // manifest, three arrays, the other one
}

TEST(ArraySet, EveryDamageOfTheManifestIsSeen) {
  const sample::TemporaryFolder folder;
  write(folder.path());
  const auto manifest = folder.path() / "things.manifest";
  const std::string good = content(manifest);
  for (std::size_t i = 0; i < good.size(); ++i) {
    std::string bad = good;
    bad[i] = static_cast<char>(bad[i] ^ 1);
    EXPECT_THROW(from_text(bad, manifest), FileError) << i;
    EXPECT_THROW(from_text(good.substr(0, i), manifest), FileError) << i;
  }
}

TEST(ArraySet, MessagesNameTheFileAndWhatIsWrong) {
  const sample::TemporaryFolder folder;
  write(folder.path());
  const auto open = [&] { ArraySet::open(folder.path(), "things"); };
  const auto points = file_of(folder.path(), "points"), manifest = folder.path() / "things.manifest";
  std::string bytes = content(points);
  bytes[5] = static_cast<char>(bytes[5] ^ 4);
  put(points, bytes);
  const ArraySet damaged = ArraySet::open(folder.path(), "things");  // its size is right
  EXPECT_EQ(message_of<FileError>([&] { damaged.check(1); }),
            points.string() + ": is damaged: it does not have its checksum");
  put(points, bytes.substr(1));
  EXPECT_EQ(message_of<FileError>(open), points.string() + ": is damaged: it has 47 bytes, not 48");
  std::filesystem::remove(points);
  EXPECT_EQ(message_of<FileError>(open), points.string() + ": cannot be read: No such file or directory");
  put(manifest, "ifa arrays 2\nsomething else\n");
  EXPECT_EQ(message_of<FileError>(open),
            manifest.string() + ": is of format 2, this version of ifa reads format 1");
  put(manifest, "PK\3\4");
  EXPECT_EQ(message_of<FileError>(open), manifest.string() + ": is not a manifest of ifa");
}

TEST(FolderLock, OneAtATime) {
  const sample::TemporaryFolder folder;
  {
    const FolderLock lock(folder.path());
    EXPECT_THROW(FolderLock again(folder.path()), FileError);
  }
  EXPECT_NO_THROW(FolderLock again(folder.path()));
}

}  // namespace
}  // namespace ifa
