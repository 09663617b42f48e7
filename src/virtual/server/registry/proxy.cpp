#include "cosiva/virtual/server/registry/proxy.h"

#include <utility>

#include "cosiva/base/archive.h"

namespace cosiva::virtual_side {

void AivProxy::on_session() {
  received.on_session();
  reported_state.on_session();
  position.on_session();
  factsheet.on_session();
  on_board.on_session();
  settings.on_session();
}

void AivProxy::on_retired(SimTime now) {
  membership.on_retired();
  connection.on_offline(now);
  position.on_retired();
  settings.on_retired();
  if (!augmented()) twin_link.on_absent();
}

void AivProxy::on_returned(SimTime now) {
  AivProxy next{identity, now};
  next.twin_link = twin_link;
  next.twin_link.on_returned();
  next.settings.set_priority(settings.priority());
  next.sent = sent;
  next.counters = counters;
  AgentProxy& counts = next;
  const AgentProxy& counts_before = *this;
  counts = counts_before;
  *this = std::move(next);
}

void AivProxy::archive(Archive& archive) {
  archive(membership, twin_link, settings, connection, factsheet, reports, clock, reported_state, position, on_board,
          received, sent, counters, diagnostics);
  AgentProxy::archive(archive);
}

}  // namespace cosiva::virtual_side
