// Bullet as a peer, set up as its documentation advises and, where
// the defaults would spoil its bounces, as measured to suit it:
// - btConvexHullShape on btStaticPlaneShape; its margin is the rounding radius, which makes it the hull
// rounded
//   by exactly that. Mass and principal inertia are the body's.
// - Small bodies are to be scaled up to about one unit (wiki, "Scaling the world"): the unit is 1 cm.
// - Newton restitution and Coulomb friction are Bullet's own, multiplied with the ground's 1. Impacts slower
//   than the event engine's micro speed do not bounce here either. Two friction directions: with one, which
//   is fixed before the impact, most of the friction of an oblique impact is lost. The two make a pyramid.
// - Contacts still apart are solved only where a body at rest would fall that far (twice over) within the
// step.
//   By default they are from further, which slows the approach before the bounce: restitution falls with the
//   step.
// - Split impulses at any depth. By default shallow penetration is pushed out by a velocity that stays: at
// small
//   steps restitution grows by up to 0.2.
// - Implicit gyroscopic torque and 10 sweeps: the defaults. Sleeping is off: one criterion of rest serves all
//   engines. Each call of stepSimulation is one step.
// Double precision (Bullet's -float64 libraries), as all engines here.
#include <btBulletDynamicsCommon.h>

#include <algorithm>
#include <string>

#include "peer.hpp"

namespace {

constexpr double kUnitsPerM = 100.0;

class World {
 public:
  World(const PeerBody& body, const PeerOptions& options)
      : dispatcher_(&configuration_),
        world_(&dispatcher_, &broadphase_, &solver_, &configuration_),
        plane_(btVector3(0, 0, 1), 0),
        ground_(0.0, nullptr, &plane_),
        body_(construction_info(body, hull_)) {
    world_.setGravity(btVector3(0, 0, -options.gravity_m_s2 * kUnitsPerM));
    world_.getSolverInfo().m_restitutionVelocityThreshold = options.micro_speed_m_s * kUnitsPerM;
    world_.getSolverInfo().m_solverMode |= SOLVER_USE_2_FRICTION_DIRECTIONS;
    world_.getSolverInfo().m_splitImpulsePenetrationThreshold = 0;
    ground_.setRestitution(1);
    ground_.setFriction(1);
    body_.setActivationState(DISABLE_DEACTIVATION);
    const double falls = 2 * options.gravity_m_s2 * options.step_s * options.step_s * kUnitsPerM;
    ground_.setContactProcessingThreshold(falls);
    body_.setContactProcessingThreshold(falls);
    world_.addRigidBody(&ground_);
    for (std::int64_t i = 0; i < body.vertex_count; ++i)
      reach_ = std::max(reach_, hull_.getUnscaledPoints()[i].length());
    reach_ += body.radius_m * kUnitsPerM;
  }

  ~World() { world_.removeRigidBody(&ground_); }
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  // Runs from one state to rest or to the limit; the number of rows of its trace.
  std::int64_t run(const double* state, const PeerOptions& options, PeerEnd& end, double* trace,
                   std::int64_t room) {
    const btTransform start(btQuaternion(state[4], state[5], state[6], state[3]), units(state));
    body_.setWorldTransform(start);
    body_.setInterpolationWorldTransform(start);
    body_.setLinearVelocity(units(state + 7));
    body_.setAngularVelocity(btVector3(state[10], state[11], state[12]));
    body_.clearForces();
    world_.addRigidBody(&body_);  // anew: no contact of the simulation before is kept
    solver_.reset();
    const auto limit = static_cast<std::int64_t>(options.until_s / options.step_s);
    const double rest_steps = options.rest_span_s / options.step_s;
    std::int64_t step = 0, slow_steps = 0;
    for (;; ++step) {
      if (trace && step < room) write(static_cast<double>(step) * options.step_s, trace + kTraceWidth * step);
      const double speed = body_.getLinearVelocity().length() + reach_ * body_.getAngularVelocity().length();
      slow_steps = speed <= options.rest_speed_m_s * kUnitsPerM ? slow_steps + 1 : 0;
      end = static_cast<double>(slow_steps) > rest_steps ? peer_at_rest : peer_moving;
      if (end == peer_at_rest || step >= limit) break;
      world_.stepSimulation(options.step_s, 0);
    }
    world_.removeRigidBody(&body_);
    return step + 1;
  }

 private:
  static btVector3 units(const double* m) { return kUnitsPerM * btVector3(m[0], m[1], m[2]); }

  static btRigidBody::btRigidBodyConstructionInfo construction_info(const PeerBody& body,
                                                                    btConvexHullShape& hull) {
    for (std::int64_t i = 0; i < body.vertex_count; ++i)
      hull.addPoint(units(body.vertices_m + 3 * i), i + 1 == body.vertex_count);
    hull.setMargin(body.radius_m * kUnitsPerM);
    const double* m = body.inertia_kg_m2;
    btRigidBody::btRigidBodyConstructionInfo info(body.mass_kg, nullptr, &hull,
                                                  kUnitsPerM * kUnitsPerM * btVector3(m[0], m[1], m[2]));
    info.m_restitution = body.restitution;
    info.m_friction = body.friction;
    return info;
  }

  void write(double time_s, double* row) const {
    const btTransform& t = body_.getWorldTransform();
    const btQuaternion q = t.getRotation();
    *row++ = time_s;
    for (int i = 0; i < 3; ++i) *row++ = t.getOrigin()[i] / kUnitsPerM;
    for (const double c : {q.w(), q.x(), q.y(), q.z()}) *row++ = c;
    for (int i = 0; i < 3; ++i) *row++ = body_.getLinearVelocity()[i] / kUnitsPerM;
    for (int i = 0; i < 3; ++i) *row++ = body_.getAngularVelocity()[i];
  }

  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_;
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;
  btDiscreteDynamicsWorld world_;
  btStaticPlaneShape plane_;
  btConvexHullShape hull_;
  btRigidBody ground_, body_;
  double reach_ = 0.0;
};

}  // namespace

const char* peer_version() {
  static const std::string version = "Bullet " + std::to_string(BT_BULLET_VERSION / 100) + "." +
                                     std::to_string(BT_BULLET_VERSION % 100) + ", double precision";
  return version.c_str();
}

std::int64_t peer_run(const PeerBody* body, const PeerOptions* options, std::int64_t n, const double* states,
                      PeerEnd* ends, double* trace, std::int64_t room) {
  World world(*body, *options);
  std::int64_t rows = 0;
  for (std::int64_t i = 0; i < n; ++i)
    rows = world.run(states + kStateWidth * i, *options, ends[i], trace, room);
  return trace ? rows : 0;
}
