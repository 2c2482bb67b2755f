#pragma once
// Tags of the messages between ranks, one for each purpose: what is under way for one is never taken for another.

namespace bulkley::message_tag {

constexpr int migrants = 1;
constexpr int unasked = 3;
constexpr int cells = 5;
constexpr int slots = 7;
constexpr int plans = 9;
constexpr int node_sums = 13;
constexpr int node_values = 15;

}  // namespace bulkley::message_tag
