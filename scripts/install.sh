#!/usr/bin/env bash
# Installs what is missing for the named parts: scripts/install.sh PART...
#   build    Debian packages of the compiler and libraries, and .venv with the Python packages
#   blender  Debian's Blender and a virtual display, for the tests of the add-on
#   bench    Bullet and MuJoCo, for benchmarks/physics; after or together with build
#   extension       auditwheel, and what builds the core for Python 3.13 in build/cp313, where there is one; after build
#   bpy311, bpy313  Blender 4.5 and 5.2 as Python modules in build/bpy311 and build/bpy313, where there is that Python
# Asks nothing of the network when nothing is missing. PYTHON=... chooses the interpreter, PYTHON311=... and
# PYTHON313=... those of extension, bpy311 and bpy313.
set -euo pipefail
cd "$(dirname "$0")/.."

build_packages=(g++ cmake ninja-build libode-dev libeigen3-dev libnanoflann-dev libsndfile1-dev
                libqhull-dev libgtest-dev)
blender_packages=(blender python3-numpy xvfb xauth ffmpeg)  # ffmpeg reads rendered videos again
bpy_packages=(libgl1 libsm6 libice6 libx11-6 libxext6 libxfixes3 libxi6 libxkbcommon0 libxrender1)
bench_packages=(libbullet-dev pkg-config)
build_requirements=("scikit-build-core>=0.11" "pybind11>=2.13")  # of pyproject.toml
venv=.venv

say() { printf 'install: %s\n' "$*" >&2; }

# Whether the interpreter $1 runs, is new enough, and can make a virtual environment and compile a module.
usable_python() {
  "$1" - >/dev/null 2>&1 <<'PY'
import ensurepip, os, sys, sysconfig, venv
header = os.path.join(sysconfig.get_path("include"), "Python.h")
sys.exit(not (sys.version_info >= (3, 11) and os.path.exists(header)))
PY
}

# Debian 12's Blender runs CPython 3.11, so a module built for any 3.11 serves both.
find_python() {
  local candidate
  for candidate in ${PYTHON:-python3.11 /usr/bin/python3.11 /usr/bin/python3}; do
    if usable_python "$candidate"; then
      echo "$candidate"
      return
    fi
  done
  return 1
}

# An interpreter of just the version $1 (3.13), for what must run in Blender's own.
find_version() {
  local name="PYTHON${1/./}" candidate
  for candidate in ${!name:-"python$1" "/usr/bin/python$1" "${PYENV_ROOT:-$HOME/.pyenv}/versions/$1".*/bin/python}; do
    if usable_python "$candidate" && "$candidate" -c "import sys; sys.exit('%d.%d' % sys.version_info[:2] != '$1')"; then
      echo "$candidate"
      return
    fi
  done
  return 1
}

# The packages among the arguments that dpkg does not have installed.
missing_packages() {
  local package
  for package in "$@"; do
    dpkg-query -W -f '${db:Status-Abbrev}' "$package" 2>/dev/null | grep -q '^ii' || echo "$package"
  done
}

install_packages() {
  local command=(apt-get install -y --no-install-recommends "$@") prefix=()
  if [ "$(id -u)" -ne 0 ]; then
    if ! command -v sudo >/dev/null || ! { sudo -n true 2>/dev/null || { [ -t 0 ] && sudo -v; }; }; then
      say "these Debian packages are missing and there is no right to install them (neither root nor sudo):"
      say "    apt-get install --no-install-recommends $*"
      say "install them and run the same command again"
      exit 1
    fi
    prefix=(sudo -n)
  fi
  say "installing $*"
  prefix+=(env DEBIAN_FRONTEND=noninteractive)
  # a third-party source that is out of reach must not stop the install
  "${prefix[@]}" apt-get update -q </dev/null || say "apt-get update failed; trying with the lists at hand"
  if ! "${prefix[@]}" "${command[@]}" -q </dev/null; then
    say "apt-get could not install: $*"
    exit 1
  fi
}

packages=()
for part in "$@"; do
  case "$part" in
    build)
      packages+=("${build_packages[@]}")
      # Debian splits what usable_python asks for into packages of their own
      if [ ! -x "$venv/bin/python" ] && [ -z "${PYTHON:-}" ] && ! find_python >/dev/null; then
        packages+=(python3 python3-venv python3-dev)
      fi ;;
    blender) packages+=("${blender_packages[@]}") ;;
    bench) packages+=("${bench_packages[@]}") ;;
    bpy311|bpy313) packages+=("${bpy_packages[@]}") ;;
    extension) ;;
    *) say "unknown part '$part': build, blender, bench, extension, bpy311 or bpy313"; exit 2 ;;
  esac
done

if command -v dpkg-query >/dev/null; then
  mapfile -t missing < <(missing_packages "${packages[@]}")
  if [ "${#missing[@]}" -gt 0 ]; then install_packages "${missing[@]}"; fi
else
  say "no dpkg here: assuming that the equivalents of these Debian packages are installed: ${packages[*]}"
fi

# Whether the environment runs and its stamp $1 is newer than the list of its packages. What depends on the
# environment depends on a stamp, which changes only when the environment does.
current() { [ -e "$1" ] && [ ! pyproject.toml -nt "$1" ] && "$venv/bin/python" -c '' 2>/dev/null; }

pip_install() { "$venv/bin/python" -m pip --disable-pip-version-check install -q "$@"; }

# Only a link to python/ifa: the Makefile builds the C++ module there, once, with the C++ tests.
# (The long option: Debian 12's pip does not know -C.)
install_extra() {
  say "installing Python packages ($1) into $venv"
  pip_install --no-build-isolation --editable ".[$1]" \
    --config-settings wheel.cmake=false --config-settings editable.mode=inplace
}

# Makes the environment $2 with the packages $3... for the Python of version $1, unless it has them.
own_venv() {
  local version="$1" folder="$2" python stamp
  shift 2
  stamp="$folder/$(printf '%s ' "$@" | sha256sum | cut -c1-12)"
  [ -e "$stamp" ] && "$folder/bin/python" -c '' 2>/dev/null && return
  if ! python=$(find_version "$version"); then
    say "no Python $version with its headers here: $folder is left out (PYTHON${version/./}=... names one)"
    return
  fi
  say "making $folder with $python: $*"
  if "$python" -m venv --clear "$folder" &&
      "$folder/bin/python" -m pip --disable-pip-version-check install -q "$@"; then
    touch "$stamp"
  else
    say "could not install $* for Python $version: $folder is left out"
    rm -rf "$folder"
  fi
}

for part in "$@"; do
  case "$part" in
    extension)
      own_venv 3.13 build/cp313 "${build_requirements[@]}"
      current "$venv/installed_extension" && continue
      install_extra extension
      touch "$venv/installed_extension" ;;
    bpy311) own_venv 3.11 build/bpy311 bpy==4.5.15 ;;
    bpy313) own_venv 3.13 build/bpy313 bpy==5.2.3 ;;
    build)
      current "$venv/installed" && continue
      if ! "$venv/bin/python" -m pip --version >/dev/null 2>&1; then
        if ! python=$(find_python); then
          say "no usable Python: needs 3.11 or newer with the venv module and headers (looked at ${PYTHON:-python3.11, /usr/bin/python3})"
          exit 1
        fi
        say "making $venv with $("$python" --version) ($python)"
        "$python" -m venv --clear "$venv"
      fi
      pip_install "${build_requirements[@]}"
      install_extra dev
      touch "$venv/installed" ;;
    bench)
      current "$venv/installed_bench" && continue
      install_extra bench
      touch "$venv/installed_bench" ;;
  esac
done
