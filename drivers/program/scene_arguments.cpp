#include <fmt/format.h>

#include <filesystem>
#include <fstream>

#include "bulkley/config/toml.hpp"
#include "io/checkpoint/checkpoint.hpp"
#include "program/commands.hpp"

namespace bulkley {

void SceneArguments::declare(CLI::App& app) {
  app.add_option("scene", file, "scene file (TOML), see docs/input.md")->required()->type_name("SCENE.toml");
  app.add_option("--set", overrides, "override a key of the scene: key.path=value; may be given several times")
      ->type_name("KEY=VALUE")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
}

Scene SceneArguments::load(const Comm& comm, MeshesOf meshes) const {
  const std::string text = read_on_root(comm, file);
  Scene scene = parse_scene(text, file, overrides);  // the same on every rank, errors too
  if (comm.is_root())
    for (const std::string& warning : scene.warnings) fmt::print(stderr, "warning: {}\n", warning);
  load_meshes(comm, scene, meshes);
  return scene;
}

std::string read_on_root(const Comm& comm, const std::string& path) {
  std::string text;
  root_guard(comm, [&] {
    std::error_code ignored;
    if (std::filesystem::is_directory(path, ignored)) throw UsageError(fmt::format("{}: is a folder, not a file", path));
    std::ifstream stream(path, std::ios::binary);
    if (!stream) throw UsageError(fmt::format("{}: cannot be opened", path));
    text.resize(config::largest_text + 1);  // a device may never end
    stream.read(text.data(), static_cast<std::streamsize>(text.size()));
    if (stream.bad()) throw UsageError(fmt::format("{}: cannot be read", path));
    text.resize(static_cast<std::size_t>(stream.gcount()));
    if (text.size() > config::largest_text)
      throw UsageError(fmt::format("{}: is larger than {} MiB", path, config::largest_text >> 20));
  });
  return broadcast_text(comm, std::move(text));
}

std::string resolve_checkpoint(const Comm& comm, const std::string& path) {
  GlobalIndex kind = 0;  // 0 missing, 1 file, 2 folder
  if (comm.is_root()) {
    std::error_code ignored;
    if (std::filesystem::exists(path, ignored)) kind = std::filesystem::is_directory(path, ignored) ? 2 : 1;
  }
  kind = max_global(comm, kind);
  if (kind == 0) throw UsageError(fmt::format("{}: no such file or folder", path));
  if (kind == 1) return path;
  std::vector<std::string> warnings;
  const auto latest = find_latest_checkpoint(comm, path, warnings);
  if (comm.is_root())
    for (const std::string& warning : warnings) fmt::print(stderr, "warning: {}\n", warning);
  if (!latest) throw UsageError(fmt::format("{}: holds no whole checkpoint", path));
  return *latest;
}

}  // namespace bulkley
