// ranks: 1 2 3 4
#include <gtest/gtest.h>
#include <petscsys.h>

#include "distribution/exchange.hpp"
#include "support/traffic_case.hpp"

namespace bulkley::traffic_mpi_test {
namespace {

TEST(Traffic, IsThatOfTheExchange) {
  const Comm comm(PETSC_COMM_WORLD);
  GlobalIndex n_messages = 0;
  for_each_case(comm.size(), [&](const TrafficCase& c) {
    const PoolLayout pool = c.pool(comm.rank());
    const Exchange exchange(comm, c.grid, c.map, pool);
    const RankTraffic mine = predict_traffic(c.grid, c.map, c.load)[comm.rank()];
    EXPECT_EQ(mine.n_tiles, static_cast<GlobalIndex>(pool.tiles().size()));
    EXPECT_EQ(mine.n_pool_nodes, pool.n_nodes());
    EXPECT_EQ(mine.bytes_add, static_cast<GlobalIndex>(exchange.sent_by_add().bytes));
    EXPECT_EQ(mine.bytes_get, static_cast<GlobalIndex>(exchange.sent_by_get().bytes));
    EXPECT_EQ(mine.messages_add, exchange.sent_by_add().n_messages);
    EXPECT_EQ(mine.messages_get, exchange.sent_by_get().n_messages);
    n_messages += mine.messages_add;
  });
  if (comm.size() > 1) {
    EXPECT_GT(sum_global(comm, n_messages), 0);
  }
}

}  // namespace
}  // namespace bulkley::traffic_mpi_test
