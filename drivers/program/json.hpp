#pragma once
// JSON objects put together value by value, and single numbers read back from them.

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "bulkley/base/types.hpp"

namespace bulkley {

/// An object whose keys keep their order. Not collective.
class JsonObject {
 public:
  JsonObject& add(std::string key, const std::string& value);
  JsonObject& add(std::string key, double value);  ///< a measured value: six digits; null if not finite
  JsonObject& add(std::string key, GlobalIndex value);
  JsonObject& add(std::string key, int value) { return add(std::move(key), GlobalIndex{value}); }
  JsonObject& add(std::string key, const JsonObject& value);
  JsonObject& add(std::string key, const std::vector<JsonObject>& values);

  /// On several lines, those after the first indented by `indent` spaces.
  std::string text(int indent = 0) const;

 private:
  struct Entry {
    std::string key;
    std::string value;                ///< as written, of numbers and strings
    std::vector<JsonObject> objects;  ///< of objects and lists
    bool is_list = false;
  };
  std::vector<Entry> entries_;
};

/// The number after the first `"key":` of a text that JsonObject wrote; NaN when there is none. Not collective.
double json_number(std::string_view text, std::string_view key);

}  // namespace bulkley
