// A Raspberry Pi Pico as an instrument: the maker's board but for what follows.
#define MICROPY_HW_BOARD_NAME "Raspberry Pi Pico with layerjam"

// a program that opens the port at 1200 baud does not end the firmware
#define MICROPY_HW_USB_CDC_1200BPS_TOUCH (0)

// the collector walks the whole heap again where this stack is too small: 64 entries cost 7 ms
#define MICROPY_ALLOC_GC_STACK_SIZE (1024)
