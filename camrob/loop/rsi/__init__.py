"""The tracker loop on a real controller: RSI frames, the instrument's datagrams, and what is believed of them."""
