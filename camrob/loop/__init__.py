"""The tracker loop: a laser tracker watches the tool and the programmed path is corrected while it runs."""
