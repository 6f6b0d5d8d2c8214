/* Everything of the Quoin contact-law ABI. */
#ifndef QUOIN_QUOIN_H
#define QUOIN_QUOIN_H
#include "quoin/base.h"
#include "quoin/batch.h"
#include "quoin/law.h"
#include "quoin/metadata.h"
#endif
