!> A vector that is mostly zero, and a queue of its places: work on it costs what its entries cost.
module taut_linalg_sparse_vector
   use taut_kinds, only: wp
   implicit none (type, external)
   private
   public :: sparse_vector_t

   !> The vector.
   type :: sparse_vector_t
      !> Its entries, zero but in the places that are listed: (n).
      real(wp), allocatable :: value(:)
      !> The places, in any order: the first `number`.
      integer, allocatable :: place(:)
      integer :: number = 0
      logical, allocatable, private :: listed(:)
      !> A heap of places that wait, with the sign of the order in which they come.
      integer, allocatable, private :: waiting(:)
      integer, private :: in_queue = 0
   contains
      procedure :: init
      procedure :: clear
      procedure :: add
      procedure :: take
      procedure :: scale
      procedure :: norm
      procedure :: largest
      procedure :: queue_up
      procedure :: take_next
      procedure :: reach
   end type sparse_vector_t

contains

   !> A vector of zeros; nothing is allocated afterwards.
   subroutine init(self, n)
      !> The vector.
      class(sparse_vector_t), intent(out) :: self
      !> Its length.
      integer, intent(in) :: n

      allocate (self%value(n), source=0.0_wp)
      allocate (self%listed(n), source=.false.)
      allocate (self%place(n), self%waiting(n), source=0)
   end subroutine init

   !> All entries become zero.
   pure subroutine clear(self)
      !> The vector.
      class(sparse_vector_t), intent(inout) :: self
      integer :: i

      do i = 1, self%number
         self%value(self%place(i)) = 0.0_wp
         self%listed(self%place(i)) = .false.
      end do
      self%number = 0
   end subroutine clear

   !> Adds to an entry.
   pure subroutine add(self, i, x)
      !> The vector.
      class(sparse_vector_t), intent(inout) :: self
      !> Its place.
      integer, intent(in) :: i
      !> What is added.
      real(wp), intent(in) :: x

      if (.not. self%listed(i)) call list(self, i)
      self%value(i) = self%value(i) + x
   end subroutine add

   !> Becomes another one.
   pure subroutine take(self, other)
      !> The vector.
      class(sparse_vector_t), intent(inout) :: self
      !> What it becomes, of its length.
      type(sparse_vector_t), intent(in) :: other
      integer :: i

      call self%clear()
      do i = 1, other%number
         call self%add(other%place(i), other%value(other%place(i)))
      end do
   end subroutine take

   !> Multiplies it.
   pure subroutine scale(self, factor)
      !> The vector.
      class(sparse_vector_t), intent(inout) :: self
      !> By what.
      real(wp), intent(in) :: factor
      integer :: i

      do i = 1, self%number
         self%value(self%place(i)) = factor*self%value(self%place(i))
      end do
   end subroutine scale

   pure subroutine list(self, i)
      type(sparse_vector_t), intent(inout) :: self
      integer, intent(in) :: i

      self%listed(i) = .true.
      self%number = self%number + 1
      self%place(self%number) = i
   end subroutine list

   !> Its length.
   pure real(wp) function norm(self)
      !> The vector.
      class(sparse_vector_t), intent(in) :: self
      integer :: i

      norm = 0.0_wp
      do i = 1, self%number
         norm = norm + self%value(self%place(i))**2
      end do
      norm = sqrt(norm)
   end function norm

   !> The place of its largest entry; of equals, the first one.
   pure integer function largest(self)
      !> The vector, not empty.
      class(sparse_vector_t), intent(in) :: self
      integer :: i, p

      largest = self%place(1)
      do i = 2, self%number
         p = self%place(i)
         if (abs(self%value(p)) < abs(self%value(largest))) cycle
         if (abs(self%value(p)) > abs(self%value(largest)) .or. p < largest) largest = p
      end do
   end function largest

   !> All places that are listed are to be taken one after the other.
   pure subroutine queue_up(self, order)
      !> The vector.
      class(sparse_vector_t), intent(inout) :: self
      !> 1: the first place comes first; -1: the last one.
      integer, intent(in) :: order
      integer :: i

      self%in_queue = 0
      do i = 1, self%number
         call push(self, order*self%place(i))
      end do
   end subroutine queue_up

   !> Takes the place that is next.
   pure subroutine take_next(self, i)
      !> The vector.
      class(sparse_vector_t), intent(inout) :: self
      !> The place; 0 where none is left.
      integer, intent(out) :: i
      integer :: child, j, moved

      i = 0
      if (self%in_queue == 0) return
      i = abs(self%waiting(1))
      moved = self%waiting(self%in_queue)
      self%in_queue = self%in_queue - 1
      j = 1
      do
         child = 2*j
         if (child > self%in_queue) exit
         if (child < self%in_queue) then
            if (self%waiting(child + 1) < self%waiting(child)) child = child + 1
         end if
         if (moved <= self%waiting(child)) exit
         self%waiting(j) = self%waiting(child)
         j = child
      end do
      self%waiting(j) = moved
   end subroutine take_next

   !> Adds to an entry that comes later in the queue; one that was zero joins it.
   pure subroutine reach(self, i, x, order)
      !> The vector.
      class(sparse_vector_t), intent(inout) :: self
      !> Its place.
      integer, intent(in) :: i
      !> What is added.
      real(wp), intent(in) :: x
      !> As of `queue_up`.
      integer, intent(in) :: order

      if (.not. self%listed(i)) then
         call list(self, i)
         call push(self, order*i)
      end if
      self%value(i) = self%value(i) + x
   end subroutine reach

   !> Into the heap.
   pure subroutine push(self, key)
      type(sparse_vector_t), intent(inout) :: self
      integer, intent(in) :: key
      integer :: j

      self%in_queue = self%in_queue + 1
      j = self%in_queue
      do while (j > 1)
         if (self%waiting(j/2) <= key) exit
         self%waiting(j) = self%waiting(j/2)
         j = j/2
      end do
      self%waiting(j) = key
   end subroutine push

end module taut_linalg_sparse_vector
