#include "bench/io.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <vector>

#include "bench/run.hpp"
#include "io/checkpoint/checkpoint.hpp"
#include "io/files/text_file.hpp"
#include "io/frames/frame.hpp"
#include "io/status/status.hpp"

namespace bulkley {

namespace {

constexpr std::size_t plain_portion = std::size_t{16} << 20;  // bytes

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

// Columns of this rank, filled so that no two neighbouring doubles are equal.
ParticleSet made_up_particles(GlobalIndex first, LocalIndex n) {
  ParticleSet particles;
  particles.resize(n);
  std::uint64_t state = static_cast<std::uint64_t>(first) * 0x9e3779b97f4a7c15u + 1;
  for (const FieldInfo& field : field_table) {
    if (!particles.has(field.field) || field.type != FieldType::real) continue;
    for (int c = 0; c < field.n_components; ++c)
      for (LocalIndex p = 0; p < n; ++p) {
        state = state * 6364136223846793005u + 1442695040888963407u;
        particles.real(field.field, c)[p] = static_cast<double>(state >> 11) * 0x1p-53;
      }
  }
  for (LocalIndex p = 0; p < n; ++p) particles.id()[p] = first + p;
  return particles;
}

[[noreturn]] void refuse(const std::string& file) {
  throw RunError(fmt::format("bench --io: '{}': {}", file, std::strerror(errno)));
}

// A file that is closed at the end of the scope.
class PlainFile {
 public:
  PlainFile(const std::string& path, int flags) : path_(path), file_(::open(path.c_str(), flags | O_CLOEXEC, 0666)) {
    if (file_ < 0) refuse(path);
  }
  ~PlainFile() { ::close(file_); }
  PlainFile(const PlainFile&) = delete;
  PlainFile& operator=(const PlainFile&) = delete;

  void write(std::vector<std::byte>& buffer, std::size_t bytes) {
    while (bytes > 0) {
      const ssize_t n = ::write(file_, buffer.data(), std::min(bytes, buffer.size()));
      if (n < 0) refuse(path_);
      bytes -= static_cast<std::size_t>(n);
    }
    if (::fsync(file_) != 0) refuse(path_);
  }
  void read_all(std::vector<std::byte>& buffer) {
    for (ssize_t n = 1; n != 0;)
      if (n = ::read(file_, buffer.data(), buffer.size()); n < 0) refuse(path_);
  }
  void forget() { ::posix_fadvise(file_, 0, 0, POSIX_FADV_DONTNEED); }

 private:
  std::string path_;
  int file_;
};

void forget(const std::string& file) { PlainFile(file, O_RDONLY).forget(); }

double seconds_of(const Comm& comm, const std::function<void()>& work) {
  BULKLEY_MPI(MPI_Barrier(comm.get()));
  const double begin = MPI_Wtime();
  work();
  BULKLEY_MPI(MPI_Barrier(comm.get()));
  return max_global(comm, MPI_Wtime() - begin);
}

}  // namespace

Json bench_io(const Comm& comm, const IoBench& what) {
  root_guard(comm, [&] {
    std::error_code error;
    std::filesystem::create_directories(what.folder, error);
    if (error) throw RunError(fmt::format("bench --io: '{}': {}", what.folder, error.message()));
  });
  const EvenShare share = even_share(comm, what.n_particles);
  const ParticleSet particles = made_up_particles(share.first, static_cast<LocalIndex>(share.count()));
  const std::vector<NamedMaterial> materials{{"made_up", NeoHookean{}}};
  const std::vector<std::string> names{materials[0].name};
  const std::string plain = path_in(what.folder, "plain.bin"), file = checkpoint_path(what.folder, 1);
  const std::string frame = frame_path(what.folder, 0);
  const auto before = static_cast<double>(peak_resident_bytes());

  CheckpointHeader header;
  header.step = 1;
  std::vector<double> plain_write, plain_read, write, read, frame_write;
  double bytes = 0.0, frame_bytes = 0.0, io_memory = 0.0;
  for (int round = 0; round < what.n_rounds; ++round) {
    write.push_back(seconds_of(comm, [&] { write_checkpoint(comm, what.folder, header, particles, names, 1); }));
    if (round == 0) io_memory = max_global(comm, static_cast<double>(peak_resident_bytes()) - before);
    root_guard(comm, [&] { bytes = static_cast<double>(std::filesystem::file_size(file)); });
    std::vector<std::byte> buffer(comm.is_root() ? plain_portion : 0, std::byte{0x5a});
    plain_write.push_back(on_root_alone(comm, [&] {
      const double begin = MPI_Wtime();
      PlainFile(plain, O_WRONLY | O_CREAT | O_TRUNC).write(buffer, static_cast<std::size_t>(bytes));
      return MPI_Wtime() - begin;
    }));
    root_guard(comm, [&] {
      forget(plain);
      forget(file);
    });
    plain_read.push_back(on_root_alone(comm, [&] {
      const double begin = MPI_Wtime();
      PlainFile(plain, O_RDONLY).read_all(buffer);
      return MPI_Wtime() - begin;
    }));
    ParticleSet back;
    read.push_back(seconds_of(comm, [&] { read_checkpoint(comm, file, share.first, share.count(), back); }));
    frame_write.push_back(seconds_of(comm, [&] {
      write_frame(comm, what.folder, {0, 0, 0.0, 0}, particles, materials, {}, nullptr, nullptr);
    }));
    root_guard(comm, [&] {
      frame_bytes = static_cast<double>(std::filesystem::file_size(frame));
      for (const std::string& name : {plain, file, frame}) {
        remove_file(name);
        remove_file(std::filesystem::path(name).replace_extension(".xdmf").string());
      }
    });
  }
  return {{"particles", what.n_particles},
          {"ranks", comm.size()},
          {"checkpoint_bytes", rounded(bytes)},
          {"checkpoint_write_MB_per_s", rounded(1e-6 * bytes / median(write))},
          {"plain_write_MB_per_s", rounded(1e-6 * bytes / median(plain_write))},
          {"write_over_plain", rounded(median(plain_write) / median(write))},
          {"checkpoint_read_MB_per_s", rounded(1e-6 * bytes / median(read))},
          {"plain_read_MB_per_s", rounded(1e-6 * bytes / median(plain_read))},
          {"read_over_plain", rounded(median(plain_read) / median(read))},
          {"frame_bytes", rounded(frame_bytes)},
          {"frame_write_MB_per_s", rounded(1e-6 * frame_bytes / median(frame_write))},
          {"memory_of_a_write_MB_per_rank", rounded(1e-6 * io_memory)}};
}

}  // namespace bulkley
