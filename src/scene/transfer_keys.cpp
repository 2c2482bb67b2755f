#include "scene/transfer_keys.hpp"

namespace bulkley {

config::Names<TransferScheme> names(config::Of<TransferScheme>) {
  return {{"pic", TransferScheme::pic},
          {"flip", TransferScheme::flip},
          {"blend", TransferScheme::blend},
          {"apic", TransferScheme::apic}};
}

config::Names<SplineOrder> names(config::Of<SplineOrder>) {
  return {{"quadratic", SplineOrder::quadratic}, {"cubic", SplineOrder::cubic}};
}

config::Names<GradientForm> names(config::Of<GradientForm>) {
  return {{"mls", GradientForm::mls}, {"bspline", GradientForm::bspline}};
}

const config::Keys<TransferSettings>& keys(config::Of<TransferSettings>) {
  using S = TransferSettings;
  static const auto table =
      config::Keys<S>("How momentum is transferred between particles and grid.")
          .key("scheme", &S::scheme,
               {.about = "PIC damps, FLIP keeps all noise, blend mixes the two, APIC conserves angular momentum."})
          .key("order", &S::order, {.about = "Degree of the B-spline weights."})
          .key("gradient", &S::gradient,
               {.about =
                    "Form of the velocity gradient and of the internal forces: by moving least squares, or by the gradients "
                    "of the weights."})
          .key("flip_ratio", &S::flip_ratio, {.about = "Weight of FLIP in the blend.", .range = config::between(0.0, 1.0)})
          .only_with("scheme = \"blend\"", [](const S& s) { return s.scheme == TransferScheme::blend; })
          .key("affine_damping", &S::affine_damping,
               {.about =
                    "Fraction of the symmetric part of the affine matrix that each step removes; 1 keeps the rotation only.",
                .range = config::between(0.0, 1.0)})
          .only_with("scheme = \"apic\"", [](const S& s) { return s.scheme == TransferScheme::apic; });
  return table;
}

}  // namespace bulkley
