// Sound files and the loudness of marks.
#include <pybind11/stl/filesystem.h>

#include "bindings.hpp"
#include "ifa/sound/envelope.hpp"
#include "ifa/sound/file.hpp"

namespace ifa::bindings {

void bind_sound(py::module_& m) {
  m.def(
      "read_sound",
      [](const std::filesystem::path& path) {
        Sound sound;
        {
          const py::gil_scoped_release release;
          sound = read_sound(path);
        }
        Array samples(static_cast<py::ssize_t>(sound.samples.size()));
        double* out = samples.mutable_data();
        {
          const py::gil_scoped_release release;
          std::copy(sound.samples.begin(), sound.samples.end(), out);
        }
        return py::make_tuple(samples, sound.sample_rate_hz);
      },
      py::arg("path"));

  m.def(
      "write_wav",
      [](const std::filesystem::path& path, const Array& samples, int sample_rate_hz, int bits) {
        const std::vector<double> checked = to_vector(samples, "samples");
        const py::gil_scoped_release release;
        write_wav(path, Sound{{checked.begin(), checked.end()}, sample_rate_hz}, bits);
      },
      py::arg("path"), py::arg("samples"), py::arg("sample_rate_hz"), py::arg("bits") = 16);

  m.def(
      "mark_amplitudes",
      [](const std::filesystem::path& path, const Array& times_s, const Array& durations_s) {
        const std::vector<double> times = to_vector(times_s, "times_s");
        const std::vector<double> durations = to_vector(durations_s, "durations_s");
        MarkAmplitudes found;
        {
          const py::gil_scoped_release release;
          found = mark_amplitudes(read_sound(path), times, durations);
        }
        return py::make_tuple(from_vector(found.amplitudes), from_vector(found.centroids_s));
      },
      py::arg("path"), py::arg("times_s"), py::arg("durations_s"));
}

}  // namespace ifa::bindings
