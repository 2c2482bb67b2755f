#pragma once
// Keys of [transfer] of a scene.

#include "bulkley/config/keys.hpp"
#include "kernel/transfer.hpp"

namespace bulkley {

config::Names<TransferScheme> names(config::Of<TransferScheme>);
config::Names<SplineOrder> names(config::Of<SplineOrder>);
config::Names<GradientForm> names(config::Of<GradientForm>);
config::Names<Dilation> names(config::Of<Dilation>);
const config::Keys<TransferSettings>& keys(config::Of<TransferSettings>);

}  // namespace bulkley
