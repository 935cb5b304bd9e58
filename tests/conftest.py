"""For all tests."""

import signal

# A shell that starts us in the background makes us ignore Ctrl-C, and our tests send it.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)
