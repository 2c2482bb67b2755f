#pragma once
// Arrays that are as large as the material is spread out, and filled anew whenever that changes.

#include <cstddef>

namespace bulkley {

/// Room for `n` values, which are undefined afterwards. Where there is not enough the old memory is returned before the new one is
/// taken, so that the two are never there together; a little more than `n` is reserved, because material goes on spreading.
template <class Vector>
void renew(Vector& values, std::size_t n) {
  if (n > values.capacity()) {
    values = Vector();
    values.reserve(n + n / 16);
  }
  values.resize(n);
}

}  // namespace bulkley
