// The pairs that have contact points, by joint family.
#pragma once

namespace quoin::blocks {

struct World;

// Lists them anew (Contacts::of_family), after pairs have come or gone: also one without points gives others new
// numbers.
void list_contacts_by_family(World& w);

}  // namespace quoin::blocks
