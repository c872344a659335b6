# SPDX-License-Identifier: MIT
# turnscale with its simulator, from the Debian packages:
#
#   docker build --tag turnscale .
#   docker run --rm --volume "$PWD:/data" turnscale run drive.mp4 --lever-arm 1.45 --out out
FROM debian:12 AS build
WORKDIR /turnscale
COPY scripts/install-dependencies scripts/
# git: for the commit in `turnscale --version`.
RUN apt-get update && \
    apt-get install -y --no-install-recommends git && \
    scripts/install-dependencies --package && \
    rm -rf /var/lib/apt/lists/*
COPY . .
RUN scripts/package

FROM debian:12-slim
RUN --mount=type=bind,from=build,source=/turnscale/build/packages,target=/packages \
    apt-get update && \
    apt-get install -y --no-install-recommends /packages/turnscale_*.deb /packages/turnscale-simulator_*.deb && \
    rm -rf /var/lib/apt/lists/*
WORKDIR /data
ENTRYPOINT ["turnscale"]
CMD ["--help"]
