#include "io/checkpoint/header.hpp"

#include <bit>
#include <cstring>

#include "io/arrays/checksum.hpp"

namespace bulkley {

namespace {

void put(std::string& bytes, GlobalIndex value) { bytes.append(reinterpret_cast<const char*>(&value), sizeof value); }
void put(std::string& bytes, double value) { put(bytes, std::bit_cast<GlobalIndex>(value)); }
void put(std::string& bytes, const std::string& value) {
  put(bytes, static_cast<GlobalIndex>(value.size()));
  bytes += value;
}

struct Source {
  const std::string& bytes;
  std::size_t at = 0;

  GlobalIndex integer() {
    GlobalIndex value = 0;
    std::memcpy(&value, bytes.data() + at, sizeof value);
    at += sizeof value;
    return value;
  }
  double real() { return std::bit_cast<double>(integer()); }
  std::string text() {
    const auto size = static_cast<std::size_t>(integer());
    at += size;
    return bytes.substr(at - size, size);
  }
};

}  // namespace

std::string pack_header(const CheckpointHeader& header) {
  std::string bytes;
  put(bytes, header.step);
  put(bytes, header.time);
  put(bytes, header.scene_text);
  put(bytes, header.code_version);
  put(bytes, GlobalIndex{header.n_ranks});
  put(bytes, header.n_particles);
  put(bytes, static_cast<GlobalIndex>(header.reals.size()));
  for (const auto& [name, value] : header.reals) {
    put(bytes, name);
    put(bytes, value);
  }
  put(bytes, static_cast<GlobalIndex>(header.integers.size()));
  for (const auto& [name, value] : header.integers) {
    put(bytes, name);
    put(bytes, value);
  }
  put(bytes, static_cast<GlobalIndex>(header.material_names.size()));
  for (const std::string& name : header.material_names) put(bytes, name);
  if (header.fingerprints.empty()) return bytes;
  put(bytes, static_cast<GlobalIndex>(header.fingerprints.size()));
  for (const auto& [name, fingerprint] : header.fingerprints) {
    put(bytes, name);
    put(bytes, static_cast<GlobalIndex>(fingerprint.first));
    put(bytes, static_cast<GlobalIndex>(fingerprint.second));
  }
  return bytes;
}

std::uint32_t header_crc(CheckpointHeader header) {
  header.fingerprints.clear();
  const std::string bytes = pack_header(header);
  return crc_of(reinterpret_cast<const std::byte*>(bytes.data()), bytes.size());
}

CheckpointHeader unpack_header(const std::string& bytes) {
  Source from{bytes};
  CheckpointHeader header;
  header.step = from.integer();
  header.time = from.real();
  header.scene_text = from.text();
  header.code_version = from.text();
  header.n_ranks = static_cast<int>(from.integer());
  header.n_particles = from.integer();
  for (GlobalIndex n = from.integer(); n > 0; --n) {
    const std::string name = from.text();
    header.reals[name] = from.real();
  }
  for (GlobalIndex n = from.integer(); n > 0; --n) {
    const std::string name = from.text();
    header.integers[name] = from.integer();
  }
  for (GlobalIndex n = from.integer(); n > 0; --n) header.material_names.push_back(from.text());
  if (from.at == bytes.size()) return header;
  for (GlobalIndex n = from.integer(); n > 0; --n) {
    Fingerprint& fingerprint = header.fingerprints[from.text()];
    fingerprint.first = static_cast<std::uint64_t>(from.integer());
    fingerprint.second = static_cast<std::uint64_t>(from.integer());
  }
  return header;
}

}  // namespace bulkley
