// The pairs that have contact points, by joint family.
#pragma once

namespace quoin::blocks {

struct World;

// Updates Contacts::of_family after pairs have come or gone. A pair without points, too, gives others new numbers.
void list_contacts_by_family(World& w);

}  // namespace quoin::blocks
