#include "scene/transfer_keys.hpp"

namespace bulkley {

config::Names<TransferScheme> names(config::Of<TransferScheme>) {
  return {{"pic", TransferScheme::pic},
          {"flip", TransferScheme::flip},
          {"blend", TransferScheme::blend},
          {"apic", TransferScheme::apic},
          {"moment_flip", TransferScheme::moment_flip}};
}

config::Names<SplineOrder> names(config::Of<SplineOrder>) {
  return {{"quadratic", SplineOrder::quadratic}, {"cubic", SplineOrder::cubic}};
}

config::Names<GradientForm> names(config::Of<GradientForm>) {
  return {{"mls", GradientForm::mls}, {"bspline", GradientForm::bspline}};
}

config::Names<Dilation> names(config::Of<Dilation>) {
  return {{"auto", Dilation::automatic}, {"particle", Dilation::particle}, {"cell", Dilation::cell}};
}

const config::Keys<TransferSettings>& keys(config::Of<TransferSettings>) {
  using S = TransferSettings;
  static const auto table =
      config::Keys<S>("How momentum is transferred between particles and grid.")
          .key(
              "scheme", &S::scheme,
              {.about = "PIC damps, FLIP keeps all noise, blend mixes the two, APIC conserves angular momentum; moment_flip "
                        "conserves it too, and damps at a rate, whatever the step."})
          .key("order", &S::order, {.about = "Degree of the B-spline weights."})
          .key("gradient", &S::gradient,
               {.about =
                    "Form of the velocity gradient and of the internal forces: by moving least squares, or by the gradients "
                    "of the weights."})
          .key("dilation", &S::dilation,
               {.about = "Whose volume fluids and elastic solids keep in the explicit step: that of each particle, which "
                         "locks thin sheets and layers at curved walls, or that of a material's particles in a cell "
                         "together, as `imex` does in any case. `auto`: by cell for fluids, by particle for solids."})
          .key("close_voids", &S::close_voids,
               {.about = "Whether fluids that keep their volume by cell fill, as they are sheared, what their fronts leave empty between "
                         "themselves and the face that they roll over, one on which their weight lies. If not, they reach too far on "
                         "coarse cells."})
          .key("thin_layers", &S::thin_layers,
               {.about = "Whether fluids with a yield stress may shear on a sticky face, one on which their weight lies, in a layer thinner "
                         "than a cell, as they do where they stop. If not, they stop as if the yield stress were larger, by 7 % where they "
                         "are 8 cells deep."})
          .key("flip_ratio", &S::flip_ratio,
               {.about = "Weight of FLIP in the blend, per step.", .range = config::between(0.0, 1.0)})
          .only_with("scheme = \"blend\", damping_time = 0",
                     [](const S& s) { return s.scheme == TransferScheme::blend && s.damping_time == 0.0; })
          .key("damping_time", &S::damping_time,
               {.about = "Time in which the part of the particles' motion that the grid does not see decays to 1/e. 0: for "
                         "the blend as `flip_ratio` says, for moment_flip as the two keys below say.",
                .unit = "s",
                .range = config::at_least(0.0)})
          .only_with("scheme = \"blend\" or \"moment_flip\"",
                     [](const S& s) { return s.scheme == TransferScheme::blend || s.scheme == TransferScheme::moment_flip; })
          .key("damping_strain", &S::damping_strain,
               {.about = "Strain of the fastest deforming particle in which that part decays to 1/e. Above 1 the fastest "
                         "deformation may amplify it faster than it decays.",
                .range = config::above_to(0.0, 10.0)})
          .only_with("scheme = \"moment_flip\", damping_time = 0",
                     [](const S& s) { return s.scheme == TransferScheme::moment_flip && s.damping_time == 0.0; })
          .key("damping_distance", &S::damping_distance,
               {.about = "Cells that a shear wave, or viscous diffusion, crosses in the time in which it decays to 1/e "
                         "where nothing deforms.",
                .range = config::at_least(1.0)})
          .only_with("scheme = \"moment_flip\", damping_time = 0",
                     [](const S& s) { return s.scheme == TransferScheme::moment_flip && s.damping_time == 0.0; })
          .key("affine_damping", &S::affine_damping,
               {.about =
                    "Fraction of the symmetric part of the affine matrix that each step removes; 1 keeps the rotation only.",
                .range = config::between(0.0, 1.0)})
          .only_with("scheme = \"apic\"", [](const S& s) { return s.scheme == TransferScheme::apic; });
  return table;
}

}  // namespace bulkley
