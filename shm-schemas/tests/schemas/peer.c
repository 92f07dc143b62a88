// Writes a sealed frame to standard output; the test puts the directions of a layout in.
#include "atas.h"
#include <stdio.h>
#include <string.h>

static double normal[][3] = {NORMAL};
static double tangent1[][3] = {TANGENT1};
static double tangent2[][3] = {TANGENT2};

int main(void) {
    static atas_hand_frame frame;
    memset(&frame, 0, sizeof frame);
    frame.stamp.sequence = 7;
    frame.stamp.captured_ns = (uint64_t)1 << 40;
    frame.layout_hash = atas_layout_hash(sizeof normal / sizeof normal[0], normal, tangent1, tangent2);
    frame.hand = ATAS_HAND_LEFT;
    frame.finger_count = 2;
    frame.valid_mask[1] = UINT64_MAX >> 23;
    float *force_n = &frame.force_n[0][0][0];
    for (int n = 0; n < ATAS_FINGERS * ATAS_ELEMENTS * 3; n++) {
        force_n[n] = (float)n * 0.25f;
    }
    atas_hand_frame_seal(&frame);
    if (!atas_hand_frame_is_intact(&frame) || frame.layout_hash != ATAS_LAYOUT_HASH_DOME_41) {
        return 1;
    }
    return fwrite(&frame, sizeof frame, 1, stdout) == 1 ? 0 : 2;
}
