#pragma once

#include <string>
#include <utility>
#include <vector>

#include "cosiva/wire/messages/messages.h"
#include "cosiva/wire/messages/topics.h"

/// Orders as sentences: order("O-1").through({"east@0", "east@190"}).then({"east@380"}).
namespace cosiva::aiv::test {

class OrderText {
 public:
  explicit OrderText(std::string id, std::uint32_t update_id = 0) {
    order_.order_id = std::move(id);
    order_.order_update_id = update_id;
    order_.header.version = "2.1.0";
    order_.header.manufacturer = std::string(wire::our_manufacturer);
    order_.header.serial_number = "AIV1";
  }

  /// Released nodes with the edges between them.
  OrderText& through(const std::vector<std::string>& node_ids) { return add(node_ids, true); }
  /// The horizon.
  OrderText& then(const std::vector<std::string>& node_ids) { return add(node_ids, false); }
  /// Sequence number of the first node; call before through().
  OrderText& from_sequence(std::uint32_t sequence_id) {
    next_sequence_ = sequence_id;
    return *this;
  }

  [[nodiscard]] wire::OrderNode& node(std::size_t index) { return order_.nodes[index]; }
  [[nodiscard]] wire::OrderEdge& edge(std::size_t index) { return order_.edges[index]; }
  [[nodiscard]] wire::Order& order() { return order_; }
  operator const wire::Order&() const { return order_; }  // NOLINT(google-explicit-constructor): it reads as an order

 private:
  OrderText& add(const std::vector<std::string>& node_ids, bool released) {
    for (const std::string& id : node_ids) {
      if (!order_.nodes.empty()) {
        wire::OrderEdge edge;
        edge.start_node_id = order_.nodes.back().node_id;
        edge.end_node_id = id;
        edge.edge_id = edge.start_node_id + "-" + id;
        edge.sequence_id = next_sequence_++;
        edge.released = released;
        order_.edges.push_back(std::move(edge));
      }
      wire::OrderNode node;
      node.node_id = id;
      node.sequence_id = next_sequence_++;
      node.released = released;
      order_.nodes.push_back(std::move(node));
    }
    return *this;
  }

  wire::Order order_;
  std::uint32_t next_sequence_{0};
};

inline OrderText order(std::string id, std::uint32_t update_id = 0) { return OrderText{std::move(id), update_id}; }

}  // namespace cosiva::aiv::test
