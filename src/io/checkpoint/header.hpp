#pragma once
// The header of a checkpoint as bytes: to give every rank the root's, and for its checksum.

#include <string>

#include "io/checkpoint/checkpoint.hpp"

namespace bulkley {

std::string pack_header(const CheckpointHeader& header);
/// The checksum that the file keeps of its header. It leaves out fingerprints, which programs of earlier versions do not know.
std::uint32_t header_crc(CheckpointHeader header);
/// Precondition: `bytes` come from pack_header.
CheckpointHeader unpack_header(const std::string& bytes);

}  // namespace bulkley
