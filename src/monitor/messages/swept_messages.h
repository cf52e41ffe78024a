// The steps of a cycle as messages. Pure functions.
#pragma once

#include <deformable_contact_monitor/SweptContacts.h>

#include <cstddef>
#include <cstdint>

#include "monitor/cycle_report.h"
#include "monitor/messages/contact_messages.h"

namespace deformable_contact_monitor {

// One of the report's sweeps as a message; pairs are kept as in toContactArray(), and `complete` is
// true iff the settings are complete by proof and nothing was skipped, rejected or truncated.
// Without a step, or where its detection failed, there are no pairs and `skipped` says why.
SweptContacts toSweptContacts(const CycleReport& report, const SweepReport& sweep,
                              std::size_t max_contacts,
                              std::uint64_t most_bytes = kMostMessageBytes);

}  // namespace deformable_contact_monitor
