/* Checks every size and offset of the ABI, in C. */
#include "quoin/layout_asserts.h"

int main(void) { return 0; }
