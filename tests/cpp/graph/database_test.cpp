// Built, opened, gone on with, and refused.
#include "ifa/graph/database.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "folders.hpp"
#include "ifa/graph/build.hpp"
#include "ifa/graph/harvest.hpp"
#include "ifa/graph/shard.hpp"
#include "sample_bodies.hpp"

namespace ifa {
namespace {

using sample::contents;
using sample::message_of;

constexpr std::uint64_t kSimulations = 2500;  // three shards, the last one not full

Body die() { return sample::box(Vec3::Constant(0.016), 0.005); }

Database build(const std::filesystem::path& folder, std::uint64_t simulations = kSimulations, int threads = 2,
               Progress* progress = nullptr) {
  return build_database(die(), {}, folder, simulations, threads, progress);
}

// Column by column.
void expect_same(const Nodes& a, const Nodes& b) {
  std::vector<std::string> bytes[2];
  for (int i = 0; i < 2; ++i)
    Nodes::each(i == 0 ? a : b, [&](const auto& column, int, const char*) {
      const auto view = std::as_bytes(column);
      bytes[i].emplace_back(reinterpret_cast<const char*>(view.data()), view.size());
    });
  EXPECT_EQ(bytes[0], bytes[1]);
}

TEST(Database, HoldsTheNodesOfItsSimulations) {
  const sample::TemporaryFolder folder;
  const Database built = build(folder.path() / "d");
  const NodeColumns nodes = harvest(die(), {}, {}, 0, 0, kSimulations, Recipe{}.until_s);
  expect_same(built.nodes(), view_of(nodes));
  const Database opened = Database::open(folder.path() / "d");
  expect_same(opened.nodes(), view_of(nodes));
  EXPECT_EQ(opened.simulations(), kSimulations);
  opened.check(2);
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "d" / kShardFolder));
}

TEST(Database, TheSameBytesForAnyThreads) {
  const sample::TemporaryFolder folder;
  build(folder.path() / "one", kSimulations, 1);
  build(folder.path() / "three", kSimulations, 3);
  EXPECT_EQ(contents(folder.path() / "one"), contents(folder.path() / "three"));
}

TEST(Database, GoesOnToMoreSimulations) {
  const sample::TemporaryFolder folder;
  build(folder.path() / "whole");
  build(folder.path() / "grown", 100);
  const Database small = build(folder.path() / "grown", 1500);
  build(folder.path() / "grown");
  EXPECT_EQ(contents(folder.path() / "whole"), contents(folder.path() / "grown"));
  // The smaller one is still mapped, and is the beginning of the larger one.
  expect_same(small.nodes(), Database::open(folder.path() / "grown").nodes_of_first(1500));
}

TEST(Database, AnInterruptedBuildGoesOn) {
  const sample::TemporaryFolder folder;
  const auto whole = folder.path() / "whole", other = folder.path() / "other";
  build(whole);
  Progress progress;
  progress.cancel();
  EXPECT_THROW(build(other, kSimulations, 2, &progress), Cancelled);
  EXPECT_EQ(message_of<FileError>([&] { Database::open(other); }),
            other.string() + ": is not complete; the same build goes on with it");
  // As if it had been killed: one shard whole, one damaged, one half-written.
  const auto shards = other / kShardFolder;
  const Fields fields = to_fields(settled(die()), {});
  EXPECT_EQ(from_text(sample::content(shards / "plan"), "plan").first, fields);
  sample::put(shards / "0000001024-1024.shard", "damaged");
  sample::put(shards / "0000000000-1024.shard.part", "half-written");
  build(other);
  EXPECT_EQ(contents(whole), contents(other));
}

TEST(Database, ShardsAreReadOnlyWhole) {
  const sample::TemporaryFolder folder;
  const ShardId id{77, 100, 5};
  const NodeColumns nodes = harvest(die(), {}, {}, 0, 100, 5, 60.0);
  write_shard(folder.path(), id, nodes);
  const auto shard = read_shard(folder.path(), id);
  ASSERT_TRUE(shard);
  expect_same(shard->nodes, view_of(nodes));
  const auto path = shard_path(folder.path(), id);
  const std::string good = sample::content(path);
  for (std::size_t i = 0; i < good.size(); i += 397) {
    std::string bad = good;
    bad[i] = static_cast<char>(bad[i] ^ 16);
    sample::put(path, bad);
    EXPECT_FALSE(read_shard(folder.path(), id)) << i;
    sample::put(path, good.substr(0, i));
    EXPECT_FALSE(read_shard(folder.path(), id)) << i;
  }
  sample::put(path, good);
  EXPECT_FALSE(read_shard(folder.path(), {77, 100, 6}));
  write_shard(folder.path(), {78, 100, 5}, nodes);  // of another recipe, under the same name
  EXPECT_FALSE(read_shard(folder.path(), id));
}

TEST(Database, WhatDiffersIsNamed) {
  const sample::TemporaryFolder folder;
  const auto path = folder.path() / "d";
  build(path, 10);
  const auto refused = [&](const Body& body, const Recipe& recipe, std::uint64_t simulations = 10) {
    return message_of<ArgumentError>([&] { build_database(body, recipe, path, simulations, 1); });
  };
  const std::string where = path.string();
  Recipe recipe;
  recipe.seed = 3;
  EXPECT_EQ(refused(die(), recipe), "seed: " + where + " has 0, not 3; choose another folder");
  recipe = {};
  recipe.physics.hearing.events = Events::contact;
  EXPECT_EQ(refused(die(), recipe), "events: " + where + " has audible, not contact; choose another folder");
  recipe = {};
  recipe.sampling.cone_rad = 1.0;
  EXPECT_TRUE(refused(die(), recipe).starts_with("cone_rad: "));
  const Body bouncy = die().with_material({0.9, 0.3, 5e-5, 5e-5});
  EXPECT_EQ(refused(bouncy, {}), "restitution: " + where + " has 0.5, not 0.9; choose another folder");
  EXPECT_TRUE(refused(sample::box({0.02, 0.02, 0.02}, 0.005), {}).starts_with("vertices_m: "));
  EXPECT_EQ(refused(die(), {}, 9), "simulations: " + where + " has 10, not 9; choose another folder");
  const Database database = Database::open(path);
  EXPECT_NO_THROW(database.need_body(die()));
  EXPECT_EQ(message_of<ArgumentError>([&] { database.need_body(bouncy); }),
            "body: is not that of the database: restitution: " + where + " has 0.5, not 0.9");
}

TEST(Database, APartOfAnotherBuildIsNotGoneOnWith) {
  const sample::TemporaryFolder folder;
  Progress progress;
  progress.cancel();
  EXPECT_THROW(build(folder.path(), kSimulations, 2, &progress), Cancelled);
  Recipe recipe;
  recipe.seed = 1;
  EXPECT_TRUE(message_of<ArgumentError>([&] {
                build_database(die(), recipe, folder.path(), kSimulations, 1);
              }).starts_with("seed: "));
}

TEST(Database, ForeignFoldersAreLeftAlone) {
  const sample::TemporaryFolder folder;
  sample::put(folder.path() / "letter.txt", "Dear");
  EXPECT_THROW(build(folder.path()), FileError);
  EXPECT_THROW(build(folder.path() / "letter.txt"), FileError);
  EXPECT_THROW(build(folder.path() / "a" / "b"), FileError);
  EXPECT_EQ(contents(folder.path()).size(), 1u);
  EXPECT_THROW(Database::open(folder.path()), FileError);
  EXPECT_THROW(Database::open(folder.path() / "nowhere"), FileError);
}

TEST(Database, KeepsEveryNumberOfItsRecipe) {
  const sample::TemporaryFolder folder;
  Recipe recipe;
  recipe.seed = ~std::uint64_t{0};
  recipe.physics.hearing = {Events::contact, 0.1, 1.0 / 30.0};
  recipe.sampling = {80.0 * std::numbers::pi / 180.0, 0.1, 1.0 / 3.0, 0.2, 7.0};
  recipe.until_s = 0.7;
  Body::Definition d = sample::coin({0.1 + 0.2, 0.7, 1e-5, 1e-300}).definition();
  d.name = "a 50 %25 coin\nof two lines \xc3\xa9";
  d.rings_m[0].axis = Vec3(0.1, 0.2, 3.0);
  const Body coin = Body::make(d);
  build_database(coin, recipe, folder.path(), 3, 1);
  const Database database = Database::open(folder.path());
  EXPECT_EQ(database.body().name(), d.name);
  EXPECT_EQ(difference(to_fields(database.body(), database.recipe()), to_fields(settled(coin), recipe)), "");
  EXPECT_EQ(database.recipe().seed, recipe.seed);
  EXPECT_EQ(database.recipe().sampling.most_speed_m_s, 1.0 / 3.0);
  EXPECT_EQ(database.recipe().physics.hearing.merge_gap_s, 1.0 / 30.0);
  EXPECT_EQ(database.body().material().restitution, 0.1 + 0.2);
  EXPECT_EQ(database.body().rings()[0].axis, settled(coin).rings()[0].axis);
}

TEST(Database, FieldsThatCannotBeAreNamed) {
  const auto refused = [](auto&& change) {
    Recipe recipe;
    change(recipe);
    return message_of<ArgumentError>([&] { validate(recipe); });
  };
  EXPECT_TRUE(refused([](Recipe& r) { r.sampling.cone_rad = 2.0; }).starts_with("cone_rad: "));
  EXPECT_TRUE(refused([](Recipe& r) { r.sampling.most_speed_m_s = 0.1; }).starts_with("speed_m_s: "));
  EXPECT_TRUE(refused([](Recipe& r) { r.sampling.least_spin_rad_s = -1.0; }).starts_with("spin_rad_s: "));
  EXPECT_TRUE(refused([](Recipe& r) { r.physics.hearing.merge_gap_s = 0.0; }).starts_with("merge_gap_s: "));
  EXPECT_TRUE(refused([](Recipe& r) { r.until_s = kNever; }).starts_with("until_s: "));
  const sample::TemporaryFolder folder;
  EXPECT_THROW(build(folder.path(), 0), ArgumentError);
}

}  // namespace
}  // namespace ifa
