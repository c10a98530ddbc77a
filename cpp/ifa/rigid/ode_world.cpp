#include "ifa/rigid/ode_world.hpp"

#include <ode/ode.h>

#include <cstdarg>
#include <cstdio>
#include <mutex>
#include <utility>
#include <vector>

namespace ifa {
namespace {

// What ODE reports while one of our calls runs on this thread.
struct Watch {
  bool complained = false;
};
thread_local Watch* t_watch = nullptr;

struct Trapped {};

// Set once for the process; the host may use ODE too, and keeps its own handlers outside of our calls.
dMessageFunction* g_message = nullptr;
dMessageFunction* g_error = nullptr;
dMessageFunction* g_debug = nullptr;

void pass_on(dMessageFunction* handler, int number, const char* format, va_list arguments) {
  if (handler) return handler(number, format, arguments);
  std::fprintf(stderr, "ODE %d: ", number);
  std::vfprintf(stderr, format, arguments);
  std::fputc('\n', stderr);
}

void on_message(int number, const char* format, va_list arguments) {
  if (!t_watch) return pass_on(g_message, number, format, arguments);
  t_watch->complained = true;
}

// dError calls exit, and dDebug abort, as soon as their handler returns: not to return is the only way to
// keep the host alive. ODE's frames own nothing but the memory of the world, which is given up after this.
void leave(dMessageFunction* handler, int number, const char* format, va_list arguments) {
  if (!t_watch) return pass_on(handler, number, format, arguments);
  t_watch->complained = true;
  throw Trapped{};
}
void on_error(int number, const char* format, va_list arguments) {
  leave(g_error, number, format, arguments);
}
void on_debug(int number, const char* format, va_list arguments) {
  leave(g_debug, number, format, arguments);
}

// Never undone: another thread may still be in ODE when the process ends.
void prepare_ode() {
  static std::once_flag once;
  std::call_once(once, [] {
    dInitODE2(0);
    g_message = dGetMessageHandler();
    g_error = dGetErrorHandler();
    g_debug = dGetDebugHandler();
    dSetMessageHandler(&on_message);
    dSetErrorHandler(&on_error);
    dSetDebugHandler(&on_debug);
  });
  dAllocateODEDataForThread(dAllocateMaskAll);
}

// Calls `work`; false if ODE complained. `trapped`: it cannot go on either.
template <class Work>
bool watched(bool& trapped, Work&& work) {
  Watch watch;
  Watch* const outer = std::exchange(t_watch, &watch);
  try {
    work();
  } catch (const Trapped&) {
    trapped = true;
  }
  t_watch = outer;
  return !watch.complained;
}

void put(dReal* out, const Vec3& v) { out[0] = v.x(), out[1] = v.y(), out[2] = v.z(); }

Vec3 vec3(const dReal* in) { return {in[0], in[1], in[2]}; }

dContact to_ode(const OdeContact& c, double bounce_speed) {
  dContact out{};
  put(out.geom.pos, c.position);
  put(out.geom.normal, kUp);
  out.geom.depth = c.depth;
  put(out.fdir1, c.slip_direction);
  dSurfaceParameters& s = out.surface;
  s.mode =
      dContactApprox1 | dContactFDir1 | dContactAxisDep | dContactSoftCFM | dContactSlip1 | dContactSlip2;
  s.mu = c.friction;
  s.mu2 = c.cross_friction;
  s.soft_cfm = c.softness[0];
  s.slip1 = c.softness[1];
  s.slip2 = c.softness[2];
  if (c.restitution > 0.0) {
    s.mode |= dContactBounce;
    s.bounce = c.restitution;
    s.bounce_vel = bounce_speed;
  }
  return out;
}

}  // namespace

struct OdeWorld::Parts {
  dThreadingImplementationID threading = nullptr;
  dWorldID world = nullptr;
  dJointGroupID joints = nullptr;
  dBodyID body = nullptr;
  const dReal *position = nullptr, *quaternion = nullptr, *velocity = nullptr, *angular_velocity = nullptr;
  bool gyroscopic = false;
  std::vector<dJointFeedback> feedback;
  bool trapped = false;
};

OdeWorld::OdeWorld(double mass, const Vec3& inertia, const Vec3& gravity)
    : parts_(std::make_unique<Parts>()) {
  prepare_ode();
  Parts& p = *parts_;
  watched(p.trapped, [&] {
    p.world = dWorldCreate();
    // The default threading is one for the process, and aborts if two threads step at once.
    p.threading = dThreadingAllocateSelfThreadedImplementation();
    dWorldSetStepThreadingImplementation(p.world, dThreadingImplementationGetFunctions(p.threading),
                                         p.threading);
    dWorldSetGravity(p.world, gravity.x(), gravity.y(), gravity.z());
    p.joints = dJointGroupCreate(0);
    p.body = dBodyCreate(p.world);
    p.position = dBodyGetPosition(p.body);
    p.quaternion = dBodyGetQuaternion(p.body);
    p.velocity = dBodyGetLinearVel(p.body);
    p.angular_velocity = dBodyGetAngularVel(p.body);
    dMass m;
    dMassSetParameters(&m, mass, 0, 0, 0, inertia.x(), inertia.y(), inertia.z(), 0, 0, 0);
    dBodySetMass(p.body, &m);
    dBodySetFiniteRotationMode(p.body, 1);
    p.gyroscopic = inertia.x() != inertia.y() || inertia.y() != inertia.z();
    dBodySetGyroscopicMode(p.body, p.gyroscopic);
  });
}

OdeWorld::~OdeWorld() {
  if (parts_->trapped) return;  // its memory is in no known state: let it go
  dJointGroupDestroy(parts_->joints);
  dWorldDestroy(parts_->world);
  dThreadingFreeImplementation(parts_->threading);
}

void OdeWorld::set(const State& s) {
  if (parts_->trapped) return;
  watched(parts_->trapped, [&] {
    const dBodyID body = parts_->body;
    const dQuaternion q = {s.orientation.w(), s.orientation.x(), s.orientation.y(), s.orientation.z()};
    dBodySetPosition(body, s.position.x(), s.position.y(), s.position.z());
    dBodySetQuaternion(body, q);
    dBodySetLinearVel(body, s.velocity.x(), s.velocity.y(), s.velocity.z());
    dBodySetAngularVel(body, s.angular_velocity.x(), s.angular_velocity.y(), s.angular_velocity.z());
  });
}

State OdeWorld::get() const {
  const Parts& p = *parts_;
  return {vec3(p.position), Quat(p.quaternion[0], p.quaternion[1], p.quaternion[2], p.quaternion[3]),
          vec3(p.velocity), vec3(p.angular_velocity)};
}

bool OdeWorld::step(const OdeStep& step, std::span<const OdeContact> contacts,
                    std::span<double> normal_forces) {
  Parts& p = *parts_;
  if (p.trapped) return false;
  const auto set_forces = [&](bool active) {
    dBodySetGravityMode(p.body, active);
    dBodySetGyroscopicMode(p.body, active && p.gyroscopic);
  };
  return watched(p.trapped, [&] {
    if (!contacts.empty()) {
      dWorldSetERP(p.world, step.erp);
      dWorldSetContactSurfaceLayer(p.world, step.layer);
      dWorldSetContactMaxCorrectingVel(p.world, step.correcting_speed);
      dBodyAddTorque(p.body, step.torque.x(), step.torque.y(), step.torque.z());
    }
    if (step.instant) set_forces(false);
    p.feedback.resize(normal_forces.size());
    for (std::size_t i = 0; i < contacts.size(); ++i) {
      const dContact contact = to_ode(contacts[i], step.bounce_speed);
      const dJointID joint = dJointCreateContact(p.world, p.joints, &contact);
      dJointAttach(joint, p.body, nullptr);
      if (!normal_forces.empty()) dJointSetFeedback(joint, &p.feedback[i]);
    }
    dWorldStep(p.world, step.length);
    if (step.instant) set_forces(true);
    for (std::size_t i = 0; i < normal_forces.size(); ++i) normal_forces[i] = p.feedback[i].f1[2];
    if (!contacts.empty()) dJointGroupEmpty(p.joints);
  });
}

bool without_ode_complaint(void (*work)()) {
  prepare_ode();
  bool trapped = false;
  return watched(trapped, work);
}

}  // namespace ifa
