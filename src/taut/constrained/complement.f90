!> A complement of the constraints: rows B^T that together with those of A determine a velocity, so that nu = B^T v are
!! independent velocities and v follows from A v = b' and B^T v = nu.
!!
!! With R = W^-1 - W^-1 A^T S^+ A W^-1, the projector of Eq. (11a) times W^-1, the columns of Q = R B are motions that the
!! constraints leave free, A Q = 0: the Q of Eq. (3), not of full rank where B no longer fits. Then v = A^+ b' + Q G^-1 (nu -
!! B^T A^+ b') with G = B^T Q, symmetric and positive definite; its smallest pivot, in units of that where B was chosen, says
!! how well B still fits. Redundant rows of A do no harm: R does not see them.
module taut_constrained_complement
   use taut_archive, only: archive_t
   use taut_kinds, only: wp
   use taut_constrained_projection, only: projector_t
   use taut_constrained_system, only: mechanical_system_t
   use taut_linalg_lapack, only: dpotrf, dpotrs, dpstrf
   use taut_ode_system, only: rhs_ok, rhs_retry
   implicit none (type, external)
   private
   public :: complement_t

   !> B, and what follows from it where the constraints were linearized last.
   type :: complement_t
      !> Independent velocities.
      integer :: m = 0
      !> Smallest pivot of G in units of that where B was chosen: 1 there, 0 where B no longer fits.
      real(wp) :: fit = 0.0_wp
      !> Which velocities were taken, in the order of their pivots; the first m of them count.
      integer, allocatable :: taken(:)
      !> B and Q: (n, n), the first m columns count.
      real(wp), allocatable :: b(:, :), q(:, :)
      real(wp), allocatable, private :: g(:, :), nu(:)
      !> R or what is left of it, and B^T B: (n, n).
      real(wp), allocatable, private :: free(:, :), gram(:, :), scale(:), work(:)
      real(wp), private :: pivot_when_chosen = 1.0_wp
   contains
      procedure :: init
      procedure :: choose
      procedure :: renew
      procedure :: restore
      procedure :: tangential
      procedure :: serialize
   end type complement_t

contains

   !> Makes room.
   subroutine init(self, n)
      !> The complement.
      class(complement_t), intent(out) :: self
      !> Velocities.
      integer, intent(in) :: n

      allocate (self%b(n, n), self%q(n, n), self%g(n, n), self%free(n, n), self%gram(n, n), self%nu(n), self%scale(n), &
                self%work(2*n), source=0.0_wp)
      allocate (self%taken(n), source=0)
   end subroutine init

   !> Chooses B where the constraints were linearized last, and renews what follows from it.
   !!
   !! Pivots of R, scaled to those of W^-1, tell the velocities that the constraints leave most of their freedom: these are
   !! taken, or an orthonormal basis of the null space of A, which is what the columns of the factor span.
   subroutine choose(self, model, projector, basis, info)
      !> The complement.
      class(complement_t), intent(inout) :: self
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> The projector, after `linearize`.
      type(projector_t), intent(inout) :: projector
      !> Whether B is a basis of the null space; otherwise it takes single velocities.
      logical, intent(in) :: basis
      !> `rhs_ok` or `rhs_retry`.
      integer, intent(out) :: info
      integer :: found, i, j, n

      n = model%n
      self%m = n - projector%linear%onto%rank
      associate (free => self%free, gram => self%gram, scale => self%scale, b => self%b, m => self%m)
         free(:, :) = 0.0_wp
         do j = 1, n
            free(j, j) = 1.0_wp
            call projector%linear%divide_by_weight(free(:, j))
            scale(j) = 1.0_wp/sqrt(free(j, j))
            call projector%filter_velocity(model, free(:, j))
         end do
         do j = 1, n
            do i = 1, n
               free(i, j) = scale(i)*free(i, j)*scale(j)
            end do
         end do
         call dpstrf('L', n, free, n, self%taken, found, -1.0_wp, self%work, info)
         m = min(m, found)
         b(:, :m) = 0.0_wp
         do j = 1, m
            if (.not. basis) then
               b(self%taken(j), j) = 1.0_wp
               cycle
            end if
            do i = j, n
               b(self%taken(i), j) = free(i, j)/scale(self%taken(i))
            end do
         end do
         if (basis) then
            ! B := B C^-T with B^T B = C C^T.
            do j = 1, m
               do i = j, m
                  gram(i, j) = dot_product(b(:, i), b(:, j))
               end do
            end do
            call dpotrf('L', m, gram, n, info)
            if (info /= 0) then
               info = rhs_retry
               return
            end if
            do j = 1, m
               do i = 1, j - 1
                  b(:, j) = b(:, j) - gram(j, i)*b(:, i)
               end do
               b(:, j) = b(:, j)/gram(j, j)
            end do
         end if
      end associate
      self%pivot_when_chosen = 1.0_wp
      call self%renew(model, projector, info)
      self%pivot_when_chosen = self%fit
      self%fit = 1.0_wp
   end subroutine choose

   !> Q and G where the constraints were linearized last.
   subroutine renew(self, model, projector, info)
      !> The complement, chosen.
      class(complement_t), intent(inout) :: self
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> The projector, after `linearize`.
      type(projector_t), intent(inout) :: projector
      !> `rhs_ok`, or `rhs_retry` where B does not determine a velocity.
      integer, intent(out) :: info
      integer :: i, j

      do j = 1, self%m
         self%q(:, j) = self%b(:, j)
         call projector%linear%divide_by_weight(self%q(:, j))
         call projector%filter_velocity(model, self%q(:, j))
         do i = 1, j
            self%g(j, i) = dot_product(self%b(:, j), self%q(:, i))
         end do
      end do
      call dpotrf('L', self%m, self%g, size(self%g, 1), info)
      self%fit = 0.0_wp
      if (info /= 0) then
         info = rhs_retry
         return
      end if
      self%fit = huge(1.0_wp)
      do j = 1, self%m
         self%fit = min(self%fit, self%g(j, j)**2/self%pivot_when_chosen)
      end do
      info = rhs_ok
   end subroutine renew

   !> v := v + Q G^-1 (B^T u - B^T v): gives a velocity that meets the constraints the independent ones of another.
   subroutine restore(self, u, v)
      !> The complement, renewed.
      class(complement_t), intent(inout) :: self
      !> The velocity that has them: (n).
      real(wp), intent(in), contiguous :: u(:)
      !> One that meets the constraints, replaced: (n).
      real(wp), intent(inout), contiguous :: v(:)
      integer :: info, j

      if (self%m == 0) return
      do j = 1, self%m
         self%nu(j) = dot_product(self%b(:, j), u - v)
      end do
      call dpotrs('L', self%m, 1, self%g, size(self%g, 1), self%nu, size(self%nu), info)
      do j = 1, self%m
         v(:) = v + self%q(:, j)*self%nu(j)
      end do
   end subroutine restore

   !> e := Q G^-1 B^T e: what a small change of the independent velocities makes of all of them.
   subroutine tangential(self, e)
      !> The complement, renewed.
      class(complement_t), intent(inout) :: self
      !> A change of the velocities, replaced: (n).
      real(wp), intent(inout), contiguous :: e(:)
      integer :: info, j

      do j = 1, self%m
         self%nu(j) = dot_product(self%b(:, j), e)
      end do
      e(:) = 0.0_wp
      if (self%m == 0) return
      call dpotrs('L', self%m, 1, self%g, size(self%g, 1), self%nu, size(self%nu), info)
      do j = 1, self%m
         e(:) = e + self%q(:, j)*self%nu(j)
      end do
   end subroutine tangential

   !> Passes B through an archive.
   subroutine serialize(self, archive)
      !> The complement, with room.
      class(complement_t), intent(inout) :: self
      !> The archive.
      type(archive_t), intent(inout) :: archive
      integer :: j

      call archive%item('independent velocities', self%m)
      call archive%item('pivot when chosen', self%pivot_when_chosen)
      call archive%item('fit', self%fit)
      do j = 1, min(self%m, size(self%taken))
         call archive%item('velocity taken', self%taken(j))
         call archive%item('column of B', self%b(:, j))
      end do
   end subroutine serialize

end module taut_constrained_complement
