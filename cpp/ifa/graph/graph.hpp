// The contact-event graph of a database: what a search needs of it, made once (paper section 5.2).
#pragma once

#include <memory>
#include <mutex>
#include <optional>

#include "ifa/graph/database.hpp"
#include "ifa/graph/images.hpp"
#include "ifa/graph/layered.hpp"
#include "ifa/graph/transitions.hpp"
#include "ifa/graph/trees.hpp"

namespace ifa {

// Immutable; copies share everything.
class ContactGraph {
 public:
  // Maps the transitions that lie beside the nodes, or makes them and, where the folder can be written to,
  // leaves them there for the next time. Those that gain energy are made for each call. Throws FileError,
  // Cancelled.
  static ContactGraph of(const Database& database, double energy_gain_j, int threads,
                         Progress* progress = nullptr);

  const Database& database() const { return parts_->database; }
  const Images& images() const { return parts_->images; }
  const Transitions& transitions() const { return parts_->transitions; }
  const Briefs& briefs() const { return parts_->briefs; }
  const NodeTrees& trees() const;  // made by the first call; thread-safe

 private:
  struct Parts {
    Database database;
    Images images;
    Briefs briefs;
    TransitionColumns made;        // either these
    std::optional<ArraySet> kept;  // or those
    Transitions transitions;       // what they hold
    struct LazyTrees {
      std::once_flag once;
      std::optional<NodeTrees> made;
    };
    std::unique_ptr<LazyTrees> trees = std::make_unique<LazyTrees>();
  };
  explicit ContactGraph(std::shared_ptr<const Parts> parts) : parts_(std::move(parts)) {}

  std::shared_ptr<const Parts> parts_;
};

}  // namespace ifa
