#!/bin/sh
# A large picture, and its downlink of 20 minutes.
exec sleep 1230
